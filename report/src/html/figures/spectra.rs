//! Spectra over the tooth phase and over frequency.

use super::{FLOOR, Figure, changed, legend, micro, without_after};
use crate::html::passed::highest_order;
use crate::html::plots::{self, Spectrum};
use crate::html::spectrum::{Line, spectrum, standing_out, together};
use crate::html::svg::{Area, plot, short};
use crate::html::telling::range;
use diagnosis::verdict::evidence::{Evidence, SampleCoordinates, Trace};
use std::collections::BTreeMap;

/// Orders of the own phase that are looked at: as far as the diagnosis' own harmonics reach.
const OWN_ORDERS: usize = 17;
/// Orders of the lateral phase.
const LATERAL_ORDERS: usize = 4;
/// Lines of a spectrum over frequency, and most lines of a table.
const FREQUENCIES: u32 = 200;
const ROWS: usize = 10;

/// What was looked at over the phases of all segments.
pub struct Orders {
    /// A spectrum in which something stands out of the floor.
    pub figure: Option<Figure>,
    /// What is not drawn, and why.
    pub left_out: Option<String>,
}

/// Spectrum of one channel over whole orders of a segment's own or lateral phase: of that segment, among `segments`, in which a line
/// stands farthest out of what chance gives. A segment is asked only about orders that its way really passed.
pub fn orders(evidence: &Evidence, trace: &Trace, segments: &[usize], lateral: bool) -> Orders {
    let phase = if lateral { "lateral" } else { "own" };
    let told = segments.iter().filter_map(|s| {
        let lines = of_segment(evidence, trace, *s, lateral)?;
        Some((*s, lines))
    });
    let best = told.max_by(|a, b| farthest(&a.1).total_cmp(&farthest(&b.1)));
    let Some((segment, lines)) = best else {
        let reason =
            format!("Over the {phase} tooth phase: no segment moved over enough of a tooth.");
        return Orders {
            figure: None,
            left_out: Some(reason),
        };
    };
    if farthest(&lines) < standing_out(lines.len()) {
        let reason = format!(
            "Over the {phase} tooth phase, orders 1 to {}: no wave of {} stands out of what chance gives.",
            lines.len(),
            trace.channel
        );
        return Orders {
            figure: None,
            left_out: Some(reason),
        };
    }
    let what = What {
        id: if lateral { "lateral-orders" } else { "orders" },
        title: format!(
            "Spectrum over the {phase} tooth phase of segment {}",
            segment + 1
        ),
        axis: format!("order of the {phase} tooth phase (waves a tooth)"),
        column: "order",
        named: |at| format!("order {}", short(at)),
        stems: true,
    };
    Orders {
        figure: Some(spectral(&what, trace, &lines)),
        left_out: None,
    }
}

/// Spectrum over orders between the whole ones as well: waves that are no whole number on a tooth. Only of segments that went over
/// enough teeth to tell such waves from each other, and where one stands out of what chance gives.
pub fn fractions(evidence: &Evidence, trace: &Trace, segments: &[usize]) -> Option<Figure> {
    let places: Vec<f64> = (1..=FRACTIONS * HIGHEST)
        .map(|k| f64::from(k) / f64::from(FRACTIONS))
        .collect();
    let of = |segment: &usize| {
        let turns = turns(evidence, trace, *segment, false);
        let (low, high) = range(&turns)?;
        let told = high - low >= f64::from(FRACTIONS);
        told.then(|| (*segment, spectrum(&turns, &trace.points, &places)))
    };
    let (segment, lines) = segments
        .iter()
        .filter_map(of)
        .max_by(|a, b| farthest(&a.1).total_cmp(&farthest(&b.1)))?;
    if farthest(&lines) < standing_out(lines.len()) {
        return None;
    }
    let what = What {
        id: "fractions",
        title: format!("Waves between the orders of segment {}", segment + 1),
        axis: "order of the own tooth phase (waves a tooth)".into(),
        column: "order",
        named: |at| format!("order {}", short(at)),
        stems: false,
    };
    Some(spectral(&what, trace, &lines))
}

/// Lines between two whole orders, and the highest order, of waves that are no whole number on a tooth.
const FRACTIONS: u32 = 8;
const HIGHEST: u32 = 6;

fn farthest(lines: &[Line]) -> f64 {
    lines.iter().map(Line::over_chance).fold(0.0, f64::max)
}

/// Phase of a segment at each residual, turns.
fn turns(evidence: &Evidence, trace: &Trace, segment: usize, lateral: bool) -> Vec<f64> {
    let turn = |place: &SampleCoordinates| {
        if lateral {
            place.lateral_turns[segment]
        } else {
            place.own_turns[segment]
        }
    };
    let places = trace.points.iter().map(|p| &evidence.places[p.place]);
    places.map(turn).collect()
}

/// Amplitudes of the orders that a segment's way shows; none where it shows none.
fn of_segment(
    evidence: &Evidence,
    trace: &Trace,
    segment: usize,
    lateral: bool,
) -> Option<Vec<Line>> {
    let turns = turns(evidence, trace, segment, lateral);
    let most = if lateral { LATERAL_ORDERS } else { OWN_ORDERS };
    let highest = highest_order(&turns).min(most);
    if highest == 0 {
        return None;
    }
    let orders: Vec<f64> = (1..=highest).map(|k| k as f64).collect();
    together(&turns, &trace.points, &orders)
}

/// Spectrum over frequency of the longest stretch with the highest sample rate, where something stands out of the floor.
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
    // Up to half the sample rate, and no closer than the stretch's length resolves.
    let top = (0.5 / fastest).min(f64::from(FREQUENCIES) / length_s);
    let places: Vec<f64> = (1..=FREQUENCIES)
        .map(|k| top * f64::from(k) / f64::from(FREQUENCIES))
        .collect();
    let lines = spectrum(&t_s, &trace.points, &places);
    let least = standing_out(lines.len());
    if !lines.iter().any(|l| l.over_chance() > least) {
        return None;
    }
    let what = What {
        id: "frequencies",
        title: format!("Spectrum over frequency, longest fast stretch ({length_s:.2} s)"),
        axis: "frequency, Hz".into(),
        column: "frequency, Hz",
        named: |at| format!("{} Hz", short(at)),
        stems: false,
    };
    Some(spectral(&what, &trace, &lines))
}

/// What a spectrum is over.
struct What {
    id: &'static str,
    title: String,
    axis: String,
    column: &'static str,
    named: fn(f64) -> String,
    stems: bool,
}

fn spectral(what: &What, trace: &Trace, lines: &[Line]) -> Figure {
    let after = changed(trace);
    let mut strongest = lines.to_vec();
    strongest.sort_by(|a, b| b.over_chance().total_cmp(&a.over_chance()));
    strongest.truncate(ROWS);
    let told = |l: &Line| {
        let left = if after {
            format!(", {} µm after", micro(l.after_m))
        } else {
            String::new()
        };
        format!(
            "farthest out at {}: {} µm before{left}, floor {} µm",
            (what.named)(l.at),
            micro(l.before_m),
            micro(l.floor_m)
        )
    };
    let by_chance = strongest.first().filter(|l| l.chance_m > 2.0 * l.floor_m);
    let by_chance = by_chance.map_or(String::new(), |l| {
        let chance = micro(l.chance_m);
        format!(" What is no wave in the residuals may look like one of {chance} µm by chance.")
    });
    let farthest = strongest.first().map_or(String::new(), told);
    let caption = format!(
        "{}: {farthest}. 95 % of the simulator's own scatter stays below the floor of a line.{by_chance}",
        trace.channel
    );
    let row = |l: &Line| {
        let row = [
            short(l.at),
            micro(l.before_m),
            micro(l.after_m),
            micro(l.floor_m),
        ];
        without_after(after, row.to_vec(), 2)
    };
    let header = [
        what.column,
        "amplitude before, µm",
        "after, µm",
        "floor, µm",
    ];
    let header = without_after(after, header.map(Into::into).to_vec(), 2);
    let draw = |area: &Area, narrow: bool| {
        let spectrum = Spectrum {
            lines,
            axis: &what.axis,
            named: what.named,
            after,
        };
        if what.stems {
            plots::stems(area, narrow, &spectrum)
        } else {
            plots::lines(area, narrow, &spectrum)
        }
    };
    Figure {
        id: what.id,
        title: what.title.clone(),
        plots: plot(&format!("{}. {caption}", what.title), [300, 250], draw),
        legend: legend(after, FLOOR),
        caption,
        table: (header, strongest.iter().map(row).collect()),
    }
}
