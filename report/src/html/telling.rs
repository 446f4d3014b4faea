//! Which coordinate shows the gap best, among those that a report can draw.

use crate::units;
use diagnosis::verdict::evidence::{Evidence, SampleCoordinates, Trace};
use std::borrow::Cow;

/// Cells that a coordinate is cut into.
pub const BINS: usize = 32;

/// A coordinate of a sample that can be an axis.
#[derive(Clone)]
pub struct Coordinate {
    /// Family, as the diagnosis words it; the name of a logged column.
    pub family: Cow<'static, str>,
    /// Segment, 0 to 3, or axis, where it has one.
    pub of: Option<usize>,
    /// Unit, for the axis.
    pub unit: &'static str,
    /// Value in that unit.
    pub value: fn(&SampleCoordinates, usize) -> f64,
}

impl Coordinate {
    /// Axis title.
    pub fn title(&self) -> String {
        let whose = match (self.of, self.family.as_ref()) {
            (None, _) => String::new(),
            (Some(_), column) if column.starts_with(LOGGED) => String::new(),
            (Some(axis), "place on the platen" | "deflection of the coordination sensor") => {
                format!(" {}", ["x", "y"][axis % 2])
            }
            (Some(segment), _) => format!(", segment {}", segment + 1),
        };
        format!("{}{whose}, {}", self.family, self.unit)
    }

    /// Value at a place.
    pub fn at(&self, place: &SampleCoordinates) -> f64 {
        (self.value)(place, self.of.unwrap_or(0))
    }
}

/// What the names of logged columns begin with.
const LOGGED: &str = "aux_";

/// Every coordinate of a recording.
fn all(evidence: &Evidence) -> Vec<Coordinate> {
    type Value = fn(&SampleCoordinates, usize) -> f64;
    let by_segment: [(&'static str, &'static str, Value); 5] = [
        ("own tooth phase", "turns", |p, s| {
            p.own_turns[s].rem_euclid(1.0)
        }),
        ("lateral tooth phase", "turns", |p, s| p.lateral_turns[s]),
        ("speed", "mm/s", |p, s| 1.0e3 * p.speed_m_s[s]),
        ("direction", "(−1, 0, 1)", |p, s| p.direction[s]),
        ("signal amplitude", "% from its mean", |p, s| {
            100.0 * p.ln_amplitude[s]
        }),
    ];
    let mut list = Vec::new();
    for (family, unit, value) in by_segment {
        list.extend((0..4).map(|s| Coordinate {
            family: family.into(),
            of: Some(s),
            unit,
            value,
        }));
    }
    for axis in 0..2 {
        list.push(Coordinate {
            family: "place on the platen".into(),
            of: Some(axis),
            unit: "mm",
            value: |p, a| 1.0e3 * p.centre_m[a],
        });
        list.push(Coordinate {
            family: "deflection of the coordination sensor".into(),
            of: Some(axis),
            unit: "of full scale",
            value: |p, a| p.deflection[a],
        });
    }
    list.push(Coordinate {
        family: "theta".into(),
        of: None,
        unit: "mrad",
        value: |p, _| 1.0e3 * p.theta_rad,
    });
    list.push(Coordinate {
        family: "temperature".into(),
        of: None,
        unit: "K from its mean",
        value: |p, _| p.warmth_k,
    });
    list.push(Coordinate {
        family: "time".into(),
        of: None,
        unit: "s",
        value: |p, _| p.t_s,
    });
    let logged = evidence.logged.iter().enumerate();
    list.extend(logged.map(|(k, column)| Coordinate {
        family: column.name.clone().into(),
        of: Some(k),
        unit: units::of_column(&column.name).unwrap_or("as logged"),
        value: |p, k| p.logged[k],
    }));
    list
}

/// One cell of a coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bin {
    /// Middle of the cell.
    pub at: f64,
    /// Residuals in it.
    pub count: usize,
    /// Mean before, m.
    pub before_m: f64,
    /// Mean after, m.
    pub after_m: f64,
}

/// Means over the cells of a coordinate; empty ones are left out. `None` where the coordinate does not vary.
pub fn bins(evidence: &Evidence, trace: &Trace, coordinate: &Coordinate) -> Option<Vec<Bin>> {
    let values: Vec<f64> = trace
        .points
        .iter()
        .map(|p| coordinate.at(&evidence.places[p.place]))
        .collect();
    let (low, high) = range(&values)?;
    let width = (high - low) / BINS as f64;
    let mut cells = vec![Bin::default(); BINS];
    for (point, value) in trace.points.iter().zip(&values) {
        let cell = &mut cells[(((value - low) / width) as usize).min(BINS - 1)];
        cell.count += 1;
        cell.before_m += point.before_m;
        cell.after_m += point.after_m;
    }
    let means = cells
        .into_iter()
        .enumerate()
        .filter(|(_, c)| c.count > 0)
        .map(|(k, c)| Bin {
            at: low + (k as f64 + 0.5) * width,
            count: c.count,
            before_m: c.before_m / c.count as f64,
            after_m: c.after_m / c.count as f64,
        });
    Some(means.collect())
}

/// Smallest and largest value, if there are two.
pub fn range(values: &[f64]) -> Option<(f64, f64)> {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(*v), h.max(*v))
        });
    (high - low > 1e-12 * (1.0 + high.abs().max(low.abs()))).then_some((low, high))
}

/// Share of the residual's square that the means over a coordinate take, beyond what chance gives as many cells.
fn told(evidence: &Evidence, trace: &Trace, coordinate: &Coordinate) -> f64 {
    let Some(bins) = bins(evidence, trace, coordinate) else {
        return 0.0;
    };
    let total: f64 = trace.points.iter().map(|p| p.before_m * p.before_m).sum();
    let taken: f64 = bins
        .iter()
        .map(|b| b.count as f64 * b.before_m * b.before_m)
        .sum();
    let n = trace.points.len() as f64;
    (taken / total.max(1e-30) - bins.len() as f64 / n.max(1.0)).max(0.0)
}

/// Coordinates whose number is none of a segment.
const BY_NO_SEGMENT: [&str; 2] = ["place", LOGGED];

/// The channel and coordinate that show the gap best; those that the diagnosis points to are preferred.
pub fn telling<'a>(evidence: &'a Evidence, pointed_to: &[&str]) -> Option<(&'a Trace, Coordinate)> {
    let mut best: Option<(f64, &Trace, Coordinate)> = None;
    for trace in evidence.traces.iter().filter(|t| t.points.len() > 2 * BINS) {
        for coordinate in all(evidence).into_iter().filter(|c| {
            c.of.is_none_or(|s| {
                trace.segment.is_none_or(|own| {
                    own == s || BY_NO_SEGMENT.iter().any(|f| c.family.starts_with(f))
                })
            })
        }) {
            let preferred = pointed_to
                .iter()
                .any(|place| place.contains(coordinate.family.as_ref()));
            // Time is where everything shows that differs from run to run.
            let weight = if preferred {
                3.0
            } else if coordinate.family == "time" {
                0.3
            } else {
                1.0
            };
            let score = weight * told(evidence, trace, &coordinate);
            if best.as_ref().is_none_or(|b| score > b.0) {
                best = Some((score, trace, coordinate));
            }
        }
    }
    best.map(|(_, trace, coordinate)| (trace, coordinate))
}
