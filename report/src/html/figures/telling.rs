//! Residuals over the coordinate that tells most.

use super::{FLOOR, Figure, changed, legend, micro, without_after};
use crate::html::plots::{self, Axes, MICRO, Mean};
use crate::html::svg::{AFTER, Area, BEFORE, plot, short, widened};
use crate::html::telling::{Bin, Coordinate, bins, range};
use diagnosis::verdict::evidence::{Evidence, Point, Trace};

/// Most points of one scatter plot, on a desk and on a phone.
const MOST_POINTS: [usize; 2] = [700, 300];
/// The band reaches so many standard deviations to either side: 95 % of Gaussian scatter lies within.
const BAND: f64 = 2.0;
/// All but this part of the residuals is inside the plot: single ones far outside would press the rest flat.
const INSIDE: f64 = 0.995;
/// What is left has a scale of its own where that is so many times finer.
const FINER: f64 = 1.5;

/// One of the two panels.
struct Panel {
    title: String,
    limit_um: f64,
    after: bool,
}

/// Residuals of one channel over one coordinate, before and after; before alone where nothing named changes them.
pub fn telling(evidence: &Evidence, trace: &Trace, coordinate: &Coordinate) -> Option<Figure> {
    let cells = bins(evidence, trace, coordinate)?;
    let values: Vec<f64> = trace
        .points
        .iter()
        .map(|p| coordinate.at(&evidence.places[p.place]))
        .collect();
    let x = widened(range(&values)?, 0.02);
    let title = coordinate.title();
    let floor_m = trace.floor_m();
    let panels = panels(trace, floor_m, &cells);
    let draw = |area: &Area, narrow: bool| {
        let count = panels.len();
        let parts = area.split_evenly(if narrow { (count, 1) } else { (1, count) });
        let every = trace
            .points
            .len()
            .div_ceil(MOST_POINTS[usize::from(narrow)]);
        let mut marks = Vec::new();
        for (part, panel) in parts.iter().zip(&panels) {
            let pick = |p: &Point| MICRO * if panel.after { p.after_m } else { p.before_m };
            let both = trace.points.iter().zip(&values).step_by(every.max(1));
            let points: Vec<(f64, f64)> = both.map(|(p, v)| (*v, pick(p))).collect();
            let y_title = format!("{}, µm", trace.channel);
            let axes = Axes {
                x: x.clone(),
                y: -panel.limit_um..panel.limit_um,
                x_title: &title,
                y_title: &y_title,
                title: &panel.title,
            };
            let colour = if panel.after { AFTER } else { BEFORE };
            let means: Vec<Mean> = cells
                .iter()
                .map(|c| mean(c, panel.after, coordinate))
                .collect();
            let band = BAND * MICRO * floor_m;
            marks.extend(plots::scatter(
                part,
                narrow,
                &axes,
                &points,
                &means,
                (colour, band),
            )?);
        }
        Ok(marks)
    };
    let caption = caption(trace, coordinate, &cells);
    let changed = changed(trace);
    Some(Figure {
        id: "telling",
        title: format!("Residuals of {} over {title}", trace.channel),
        plots: plot(&caption, [330, 260 * panels.len() as u32], draw),
        legend: legend(changed, FLOOR),
        table: table(coordinate, &cells, changed),
        caption,
    })
}

/// What is left is drawn on a scale of its own, so that it is seen beside the floor.
fn panels(trace: &Trace, floor_m: f64, cells: &[Bin]) -> Vec<Panel> {
    let limit = |pick: fn(&Point) -> f64, mean: fn(&Bin) -> f64| {
        let mut sorted: Vec<f64> = trace.points.iter().map(|p| pick(p).abs()).collect();
        sorted.sort_by(f64::total_cmp);
        let most = sorted[((sorted.len() - 1) as f64 * INSIDE) as usize];
        let means = cells.iter().map(|c| mean(c).abs()).fold(0.0, f64::max);
        1.1 * MICRO * most.max(means).max((BAND + 0.5) * floor_m).max(1e-12)
    };
    let before = limit(|p| p.before_m, |b| b.before_m);
    if !changed(trace) {
        let title = String::new();
        return vec![Panel {
            title,
            limit_um: before,
            after: false,
        }];
    }
    let own = limit(|p| p.after_m, |b| b.after_m);
    let finer = before / own;
    let (limit_um, title) = if finer > FINER {
        (own, format!("after, scale {} times finer", short(finer)))
    } else {
        (before, "after".to_owned())
    };
    let first = Panel {
        title: "before".into(),
        limit_um: before,
        after: false,
    };
    vec![
        first,
        Panel {
            title,
            limit_um,
            after: true,
        },
    ]
}

fn mean(bin: &Bin, after: bool, coordinate: &Coordinate) -> Mean {
    let value = if after { bin.after_m } else { bin.before_m };
    Mean {
        at: bin.at,
        value: MICRO * value,
        told: format!(
            "{} {} {}: mean {} µm of {} residuals",
            coordinate.family,
            short(bin.at),
            coordinate.unit,
            micro(value),
            bin.count
        ),
    }
}

fn caption(trace: &Trace, coordinate: &Coordinate, cells: &[Bin]) -> String {
    let swing = |pick: fn(&Bin) -> f64| {
        let values = cells.iter().map(pick);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        micro(high - low)
    };
    let swings = if changed(trace) {
        format!(
            "{} µm before and {} µm after",
            swing(|b| b.before_m),
            swing(|b| b.after_m)
        )
    } else {
        format!("{} µm", swing(|b| b.before_m))
    };
    format!(
        "Dots are single residuals of {}, the line is the mean of each of {} cells of {}. The means differ by up to {swings}; the floor of a single residual is {} µm.",
        trace.channel,
        cells.len(),
        coordinate.title(),
        micro(trace.floor_m())
    )
}

fn table(coordinate: &Coordinate, cells: &[Bin], changed: bool) -> (Vec<String>, Vec<Vec<String>>) {
    let header = [
        coordinate.title(),
        "residuals".into(),
        "mean before, µm".into(),
        "mean after, µm".into(),
    ];
    let row = |b: &Bin| {
        let row = [
            short(b.at),
            b.count.to_string(),
            micro(b.before_m),
            micro(b.after_m),
        ];
        without_after(changed, row.to_vec(), 3)
    };
    let header = without_after(changed, header.to_vec(), 3);
    (header, cells.iter().map(row).collect())
}
