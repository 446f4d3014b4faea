//! Residuals over the coordinate that tells most.

use super::{Figure, micro};
use crate::evidence::{Evidence, Trace};
use crate::html::plots::{self, Axes, MICRO};
use crate::html::svg::{AFTER, Area, BEFORE, plot, short, widened};
use crate::html::telling::{Bin, Coordinate, bins, range};

/// Most points of one scatter plot.
const MOST_POINTS: usize = 900;

/// Residuals of one channel over one coordinate, before and after.
pub fn telling(evidence: &Evidence, trace: &Trace, coordinate: &Coordinate) -> Option<Figure> {
    let cells = bins(evidence, trace, coordinate)?;
    let values: Vec<f64> = trace
        .points
        .iter()
        .map(|p| coordinate.at(&evidence.places[p.place]))
        .collect();
    let x = widened(range(&values)?, 0.02);
    let every = trace.points.len().div_ceil(MOST_POINTS).max(1);
    let mut sorted: Vec<f64> = trace
        .points
        .iter()
        .map(|p| MICRO * p.before_m.abs())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let limit = sorted[(sorted.len() - 1) * 995 / 1000].max(1e-6) * 1.1;
    let title = coordinate.title();
    let y_title = format!("{}, µm", trace.channel);
    let draw = |area: &Area, narrow: bool| {
        let parts = area.split_evenly(if narrow { (2, 1) } else { (1, 2) });
        for (part, (name, after)) in parts.iter().zip([("before", false), ("after", true)]) {
            let axes = Axes {
                x: x.clone(),
                y: -limit..limit,
                x_title: &title,
                y_title: &y_title,
                title: name,
            };
            let points: Vec<(f64, f64)> = trace
                .points
                .iter()
                .zip(&values)
                .step_by(every)
                .map(|(p, v)| (*v, MICRO * if after { p.after_m } else { p.before_m }))
                .collect();
            let means = plots::curve(
                &cells,
                if after {
                    |b: &Bin| b.after_m
                } else {
                    |b: &Bin| b.before_m
                },
            );
            plots::scatter(
                part,
                narrow,
                &axes,
                &points,
                &means,
                if after { AFTER } else { BEFORE },
            )?;
        }
        Ok(())
    };
    let swing = |pick: fn(&Bin) -> f64| {
        let (low, high) = cells
            .iter()
            .map(pick)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
        micro(high - low)
    };
    let caption = format!(
        "{} over {title}: the means of {} cells swing by {} µm before and by {} µm after.",
        trace.channel,
        cells.len(),
        swing(|b| b.before_m),
        swing(|b| b.after_m)
    );
    let rows = cells
        .iter()
        .map(|b| {
            vec![
                short(b.at),
                b.count.to_string(),
                micro(b.before_m),
                micro(b.after_m),
            ]
        })
        .collect();
    Some(Figure {
        id: "telling",
        title: format!("Residuals over {title}"),
        plots: plot(&caption, [1, 2], draw),
        table: (
            vec![
                title.clone(),
                "residuals".into(),
                "mean before, µm".into(),
                "mean after, µm".into(),
            ],
            rows,
        ),
        caption,
    })
}
