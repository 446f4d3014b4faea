//! From the baseline to the floor.

use super::{Figure, strings};
use crate::evidence::Evidence;
use crate::html::plots::{self, Bar};
use crate::html::svg::{Area, plot, short};

/// From the baseline to the floor, one effect at a time.
pub fn waterfall(evidence: &Evidence) -> Option<Figure> {
    if evidence.steps.is_empty() {
        return None;
    }
    let mut steps: Vec<(String, f64)> = evidence
        .steps
        .iter()
        .map(|s| {
            (
                if s.effect.is_empty() {
                    "baseline".into()
                } else {
                    format!("+ {}", s.effect)
                },
                s.whitened,
            )
        })
        .collect();
    steps.push(("floor".into(), 1.0));
    let caption = steps
        .iter()
        .map(|(name, value)| format!("{name} {}", short(*value)))
        .collect::<Vec<_>>()
        .join(", ");
    let caption = format!("Held-out residual over the simulator's own scatter: {caption}.");
    let count = steps.len();
    let groups = || -> Vec<(String, Vec<Bar>)> {
        // A step is drawn from where the one before ended; the first and the last stand on zero.
        let bar = |k: usize, value: f64| {
            let ends = k == 0 || k + 1 == count;
            Bar {
                from: if ends { 0.0 } else { steps[k - 1].1 },
                value,
                interval: None,
                colour: plots::step_colour(k == 0, k + 1 == count),
            }
        };
        steps
            .iter()
            .enumerate()
            .map(|(k, (name, value))| (name.clone(), vec![bar(k, *value)]))
            .collect()
    };
    let draw = |area: &Area, narrow: bool| {
        plots::bars(
            area,
            narrow,
            &groups(),
            "rms over the simulator's own scatter",
        )
    };
    Some(Figure {
        id: "waterfall",
        title: "How far the gap shrinks".into(),
        plots: plot(&caption, [1, 1], draw),
        caption,
        table: (
            strings(["step", "over the floor"]),
            steps
                .iter()
                .map(|(n, v)| vec![n.clone(), short(*v)])
                .collect(),
        ),
    })
}
