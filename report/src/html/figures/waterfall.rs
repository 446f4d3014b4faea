//! From the baseline down, one effect at a time.

use super::{Figure, strings};
use crate::html::plots::{self, Bar, BarAxis, Group};
use crate::html::svg::{AFTER, Area, BEFORE, plot, short, times};
use diagnosis::verdict::evidence::{Evidence, Step};

/// From the baseline down, one effect at a time; none where no effect makes a step.
pub fn waterfall(evidence: &Evidence) -> Option<Figure> {
    let steps = &evidence.steps;
    if steps.len() < 2 {
        return None;
    }
    let list: Vec<String> = steps
        .iter()
        .map(|s| format!("{} {}", name(s), times(s.whitened)))
        .collect();
    let caption = format!(
        "Rms of all held-out residuals in multiples of the floor: {}. The floor is 1. The pale part of a bar is what that step took away.",
        list.join(", ")
    );
    let groups = || -> Vec<Group> {
        let one = |(k, step): (usize, &Step)| {
            (
                name(step),
                vec![bar(k.checked_sub(1).map(|k| &steps[k]), step)],
            )
        };
        steps.iter().enumerate().map(one).collect()
    };
    let draw = |area: &Area, narrow: bool| {
        let axis = BarAxis {
            title: "rms, multiples of the floor",
            line: Some((1.0, "floor")),
        };
        plots::bars(area, narrow, &groups(), &axis)
    };
    Some(Figure {
        id: "waterfall",
        title: "How far the gap shrinks".into(),
        plots: plot(&caption, plots::heights(steps.len(), 1), draw),
        caption,
        legend: Vec::new(),
        table: (
            strings(["step", "multiples of the floor"]),
            steps
                .iter()
                .map(|s| vec![name(s), short(s.whitened)])
                .collect(),
        ),
    })
}

fn name(step: &Step) -> String {
    if step.effect.is_empty() {
        "baseline alone".into()
    } else {
        format!("+ {}", step.effect)
    }
}

fn bar(before: Option<&Step>, step: &Step) -> Bar {
    let told = match before {
        Some(before) => format!(
            "{}: from {} down to {} times the floor",
            name(step),
            short(before.whitened),
            short(step.whitened)
        ),
        None => format!("{}: {} times the floor", name(step), short(step.whitened)),
    };
    Bar {
        value: step.whitened,
        was: before.map(|b| b.whitened),
        interval: None,
        colour: if before.is_none() { BEFORE } else { AFTER },
        label: format!("{} ×", times(step.whitened)),
        told,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_baseline_alone_is_no_waterfall() {
        let step = |effect: &str, whitened| Step {
            effect: effect.into(),
            whitened,
        };
        let mut evidence = Evidence {
            steps: vec![step("", 3.0)],
            ..Evidence::default()
        };
        assert!(waterfall(&evidence).is_none());
        evidence.steps.push(step("velocity_lag", 1.0));
        let figure = waterfall(&evidence).unwrap();
        assert!(
            figure
                .plots
                .iter()
                .all(|p| p.svg.contains("from 3 down to 1 times"))
        );
    }
}
