//! Spectra over the tooth phase and over frequency.

use super::{Figure, micro};
use crate::evidence::{Evidence, Trace};
use crate::html::plots;
use crate::html::spectrum::{Line, spectrum};
use crate::html::svg::{plot, short};
use std::collections::BTreeMap;

/// Spectrum of one channel over the orders of a segment's own and lateral phase.
pub fn orders(evidence: &Evidence, trace: &Trace, segment: usize, lateral: bool) -> Option<Figure> {
    if trace.points.is_empty() {
        return None;
    }
    let argument: Vec<f64> = trace
        .points
        .iter()
        .map(|p| {
            if lateral {
                evidence.places[p.place].lateral_turns[segment]
            } else {
                evidence.places[p.place].own_turns[segment]
            }
        })
        .collect();
    // Across a segment only the phase within a tooth is known: whole orders.
    let (steps, per_order) = if lateral { (4, 1.0) } else { (136, 8.0) };
    let places: Vec<f64> = (1..=steps).map(|k| f64::from(k) / per_order).collect();
    let lines = series(trace, &argument, &places);
    let phase = if lateral { "lateral" } else { "own" };
    let title = format!(
        "Spectrum over the {phase} tooth phase of segment {}",
        segment + 1
    );
    let axis = format!("order of the {phase} tooth phase (waves a tooth)");
    Some(spectral(
        if lateral { "lateral-orders" } else { "orders" },
        trace,
        title,
        &axis,
        "order",
        lines,
    ))
}

/// Spectrum over frequency of the stretches with the highest sample rate.
pub fn frequencies(evidence: &Evidence, trace: &Trace) -> Option<Figure> {
    let time = |k: usize| &evidence.places[trace.points[k].place];
    let mut stretches: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for k in 0..trace.points.len() {
        stretches.entry(time(k).stretch).or_default().push(k);
    }
    let interval = |list: &Vec<usize>| {
        (time(list[list.len() - 1]).t_s - time(list[0]).t_s) / (list.len() - 1) as f64
    };
    let fastest = stretches
        .values()
        .filter(|l| l.len() > 64)
        .map(interval)
        .fold(f64::INFINITY, f64::min);
    let chosen = stretches
        .values()
        .filter(|l| l.len() > 64 && interval(l) < 2.0 * fastest)
        .max_by_key(|l| l.len())?;
    let trace = Trace {
        points: chosen.iter().map(|&k| trace.points[k]).collect(),
        ..trace.clone()
    };
    let t_s: Vec<f64> = trace
        .points
        .iter()
        .map(|p| evidence.places[p.place].t_s)
        .collect();
    let length_s = t_s[t_s.len() - 1] - t_s[0];
    let top = (0.5 / fastest).min(200.0 / length_s);
    let places: Vec<f64> = (1..=200).map(|k| top * f64::from(k) / 200.0).collect();
    let lines = series(&trace, &t_s, &places);
    let title = format!("Spectrum over frequency, longest fast stretch ({length_s:.2} s)");
    Some(spectral(
        "frequencies",
        &trace,
        title,
        "frequency, Hz",
        "frequency, Hz",
        lines,
    ))
}

fn series(trace: &Trace, argument: &[f64], places: &[f64]) -> Vec<Line> {
    let before: Vec<f64> = trace.points.iter().map(|p| p.before_m).collect();
    let after: Vec<f64> = trace.points.iter().map(|p| p.after_m).collect();
    spectrum(argument, &before, &after, places)
}

fn spectral(
    id: &'static str,
    trace: &Trace,
    title: String,
    axis: &str,
    column: &str,
    lines: Vec<Line>,
) -> Figure {
    let mut strongest = lines.clone();
    strongest.sort_by(|a, b| b.before_m.total_cmp(&a.before_m));
    strongest.truncate(10);
    let caption = strongest.first().map_or(String::new(), |l| {
        format!(
            "{}: strongest at {} with {} µm before and {} µm after.",
            trace.channel,
            short(l.at),
            micro(l.before_m),
            micro(l.after_m)
        )
    });
    let rows = strongest
        .iter()
        .map(|l| vec![short(l.at), micro(l.before_m), micro(l.after_m)])
        .collect();
    Figure {
        id,
        plots: plot(&format!("{title}. {caption}"), [1, 1], |area, narrow| {
            plots::lines(area, narrow, &trace.channel, axis, &lines)
        }),
        title,
        caption,
        table: (
            vec![
                column.into(),
                "amplitude before, µm".into(),
                "after, µm".into(),
            ],
            rows,
        ),
    }
}
