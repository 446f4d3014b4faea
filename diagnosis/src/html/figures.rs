//! The figures of the report, each with a caption and a table that say the same without a picture.

use super::plots::{self, Axes, Bar, MICRO};
use super::spectrum::{Line, spectrum};
use super::svg::{AFTER, BEFORE, FLOOR, Plot, plot, short, widened};
use super::telling::{Bin, Coordinate, bins, range};
use crate::evidence::{Evidence, Trace};
use crate::report::Diagnosis;
use std::collections::BTreeMap;

/// A figure with its equivalents in text.
pub struct Figure {
    /// Anchor.
    pub id: &'static str,
    /// Heading.
    pub title: String,
    /// What is to be seen, in words.
    pub caption: String,
    /// The plot for both widths.
    pub plots: Vec<Plot>,
    /// Header and rows of the table.
    pub table: (Vec<String>, Vec<Vec<String>>),
}

/// Most points of one scatter plot.
const MOST_POINTS: usize = 900;
/// Cells along the longer side of the map.
const MAP_CELLS: f64 = 24.0;
/// Fewest residuals in a cell of the map.
const FEWEST: usize = 3;

fn strings<const N: usize>(list: [&str; N]) -> Vec<String> {
    list.iter().map(|s| (*s).to_owned()).collect()
}

fn micro(value_m: f64) -> String {
    short(MICRO * value_m)
}

/// Residual rms of each channel: recording, with what is named, simulation.
pub fn gap(diagnosis: &Diagnosis) -> Figure {
    let channels = &diagnosis.held_out.channels;
    let groups = || -> Vec<(String, Vec<Bar>)> {
        channels
            .iter()
            .map(|c| {
                let bar = |value: f64, colour| Bar {
                    from: 0.0,
                    value: MICRO * value,
                    interval: None,
                    colour,
                };
                let after = Bar {
                    interval: Some(c.after_ci95_m.map(|v| MICRO * v)),
                    ..bar(c.after_rms_m, AFTER)
                };
                (
                    c.channel.replace('_', " "),
                    vec![
                        bar(c.before_rms_m, BEFORE),
                        after,
                        bar(c.floor_rms_m, FLOOR),
                    ],
                )
            })
            .collect()
    };
    let caption = channels
        .iter()
        .map(|c| {
            format!(
                "{}: {} µm before, {} µm after, floor {} µm",
                c.channel,
                micro(c.before_rms_m),
                micro(c.after_rms_m),
                micro(c.floor_rms_m)
            )
        })
        .collect::<Vec<_>>()
        .join("; ");
    let rows = channels
        .iter()
        .zip(&diagnosis.gap)
        .map(|(c, g)| {
            let interval = format!(
                "{} to {}",
                micro(c.after_ci95_m[0]),
                micro(c.after_ci95_m[1])
            );
            let excess = format!(
                "{} ({} to {})",
                micro(g.excess_rms_m),
                micro(g.excess_ci95_m[0]),
                micro(g.excess_ci95_m[1])
            );
            vec![
                c.channel.clone(),
                g.samples.to_string(),
                micro(c.before_rms_m),
                excess,
                micro(c.after_rms_m),
                interval,
                micro(c.floor_rms_m),
            ]
        })
        .collect();
    let header = strings([
        "channel",
        "samples",
        "recording, µm",
        "excess (95 %), µm",
        "after, µm",
        "after 95 %, µm",
        "simulation, µm",
    ]);
    Figure {
        id: "gap",
        title: "The gap at a glance".into(),
        plots: plot(
            &format!("Bars of held-out residuals. {caption}"),
            [1, 1],
            |area, narrow| plots::bars(area, narrow, &groups(), "held-out residual, rms, µm"),
        ),
        caption: format!("{caption}."),
        table: (header, rows),
    }
}

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
    let draw = |area: &super::svg::Area, narrow: bool| {
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

/// Mean residuals over the platen, before and after.
pub fn map(evidence: &Evidence, trace: &Trace) -> Option<Figure> {
    let at: Vec<[f64; 2]> = trace
        .points
        .iter()
        .map(|p| evidence.places[p.place].centre_m.map(|v| 1.0e3 * v))
        .collect();
    let spread = [0, 1].map(|axis| range(&at.iter().map(|p| p[axis]).collect::<Vec<_>>()));
    let [Some(x), Some(y)] = spread else {
        return None;
    };
    let size = (x.1 - x.0).max(y.1 - y.0) / MAP_CELLS;
    let mut cells: BTreeMap<[i64; 2], (usize, f64, f64)> = BTreeMap::new();
    for (place, point) in at.iter().zip(&trace.points) {
        let cell = cells
            .entry([
                ((place[0] - x.0) / size) as i64,
                ((place[1] - y.0) / size) as i64,
            ])
            .or_default();
        cell.0 += 1;
        cell.1 += point.before_m;
        cell.2 += point.after_m;
    }
    cells.retain(|_, cell| cell.0 >= FEWEST);
    if cells.len() < 4 {
        return None;
    }
    let middle = |key: &[i64; 2]| {
        [
            x.0 + (key[0] as f64 + 0.5) * size,
            y.0 + (key[1] as f64 + 0.5) * size,
        ]
    };
    let of = |after: bool| -> Vec<plots::Cell> {
        cells
            .iter()
            .map(|(key, c)| {
                (
                    middle(key),
                    MICRO * if after { c.2 } else { c.1 } / c.0 as f64,
                )
            })
            .collect()
    };
    let maps = [("before", of(false)), ("after", of(true))];
    let rms = |list: &[plots::Cell]| crate::statistics::rms(list.iter().map(|c| c.1));
    let full = 2.0 * rms(&maps[0].1).max(1e-6);
    let caption = format!(
        "Mean {} in {} cells of {} mm: rms {} µm before, {} µm after. Warm is positive, cool negative; full colour is {} µm.",
        trace.channel,
        cells.len(),
        short(size),
        short(rms(&maps[0].1)),
        short(rms(&maps[1].1)),
        short(full)
    );
    let mut rows: Vec<(f64, Vec<String>)> = maps[0]
        .1
        .iter()
        .zip(&maps[1].1)
        .map(|((p, b), (_, a))| {
            (
                b.abs(),
                vec![short(p[0]), short(p[1]), short(*b), short(*a)],
            )
        })
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.truncate(12);
    let draw = |area: &super::svg::Area, narrow: bool| {
        let parts = area.split_evenly(if narrow { (2, 1) } else { (1, 2) });
        for (part, (name, cells)) in parts.iter().zip(&maps) {
            plots::map(part, narrow, name, cells, size, full)?;
        }
        Ok(())
    };
    Some(Figure {
        id: "map",
        title: format!("Map over the platen, {}", trace.channel),
        plots: plot(&caption, [1, 2], draw),
        caption,
        table: (
            strings(["x, mm", "y, mm", "mean before, µm", "mean after, µm"]),
            rows.into_iter().map(|r| r.1).collect(),
        ),
    })
}

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
    let draw = |area: &super::svg::Area, narrow: bool| {
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
