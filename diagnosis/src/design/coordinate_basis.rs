//! Shapes that no catalogued effect owns: where a gap lies when nothing known explains it, and what every cause must beat.

use crate::design::frequency_basis::lines;
use crate::design::nameless::{CHANNEL, SIZE_M};
use effects::identity::Factor;
use effects::sensor::{BasisInputs, Covariates, MOST_LOGGED, Regressor};
use std::f64::consts::TAU;

/// A family of shapes over one coordinate of diagnosis.md.
pub struct CoordinateBasis {
    /// The coordinate, in the words of diagnosis.md.
    pub coordinate: String,
    /// Shapes over it.
    pub regressors: Vec<Regressor>,
}

impl CoordinateBasis {
    /// Shapes over a coordinate.
    pub fn of(coordinate: &str, regressors: Vec<Regressor>) -> Self {
        Self {
            coordinate: coordinate.into(),
            regressors,
        }
    }
}

/// Where a periodic error of the reference itself lies: at its own place and not at a segment's, the same for both of a pair.
pub const REFERENCE_PHASE: &str = "own tooth phase of the reference";

/// Every family that such a recording can show.
pub fn coordinate_bases(inputs: &BasisInputs) -> Vec<CoordinateBasis> {
    let of = CoordinateBasis::of;
    let mut list = vec![
        of("time", on_channels(inputs, time)),
        of(
            "theta",
            if inputs.turning {
                on_channels(inputs, theta)
            } else {
                Vec::new()
            },
        ),
        of("place on the platen", waves(inputs)),
        of("own tooth phase, fractional orders", own_orders(inputs)),
        of(
            "own tooth phase of both segments of a pair",
            pair_phases(inputs),
        ),
        of(REFERENCE_PHASE, reference_phase(inputs)),
        of("frequency", lines(inputs)),
    ];
    if inputs.temperature {
        list.push(of("temperature", on_channels(inputs, warmth)));
        list.push(of(
            "temperature and own tooth phase",
            times(inputs, Factor::Warmth, |m, _| m.warmth_k),
        ));
    }
    if inputs.moving {
        list.push(of("speed", accelerations(inputs)));
        let speeds = times(inputs, Factor::Speed, |m, s| m.speed_m_s[s]);
        let changes = times(inputs, Factor::Other, |m, s| m.acceleration_m_s2[s]);
        list.push(of(
            "speed and own tooth phase",
            speeds.into_iter().chain(changes).collect(),
        ));
        list.push(of(
            "direction and own tooth phase",
            times(inputs, Factor::Way, |m, s| m.direction[s]),
        ));
    }
    if inputs.counts {
        // Where the place explains the amplitude it is gap_variation's; what else changes it has no name.
        let nameless = std::array::from_fn(|s| inputs.segments[s] && !inputs.amplitude_by_place[s]);
        list.push(of(
            "signal amplitude",
            times_of(nameless, Factor::Other, |m, s| m.amplitude_excess[s]),
        ));
    }
    if inputs.beacon {
        list.push(of(
            "deflection of the coordination sensor",
            on_channels(inputs, deflection),
        ));
    }
    for (k, name) in logged_columns(inputs) {
        list.push(of(name, on_channels(inputs, move |_| logged(k))));
        list.push(of(
            &with_own_phase(name),
            times(inputs, Factor::Logged, move |m, _| m.logged[k]),
        ));
    }
    list.retain(|place| !place.regressors.is_empty());
    list
}

/// Logged columns that shapes are laid over, with their numbers. One that only rises or only falls is a clock: what follows it follows the
/// time as well.
pub fn logged_columns(inputs: &BasisInputs) -> impl Iterator<Item = (usize, &str)> {
    let all = inputs.logged.iter().take(MOST_LOGGED).enumerate();
    all.filter(|(_, column)| !column.one_way)
        .map(|(k, column)| (k, column.name.as_str()))
}

/// The coordinate of what changes with a logged column over a tooth.
pub fn with_own_phase(column: &str) -> String {
    format!("{column} and own tooth phase")
}

/// In proportion to a logged column, and bent.
fn logged(k: usize) -> Vec<Shape> {
    vec![
        Box::new(move |m| m.logged[k]),
        Box::new(move |m| m.logged[k] * m.logged[k]),
    ]
}

/// The same shapes on every channel that the recording has.
fn on_channels(
    inputs: &BasisInputs,
    shapes: impl Fn(&BasisInputs) -> Vec<Shape>,
) -> Vec<Regressor> {
    let constraint = inputs.segments.iter().all(|s| *s);
    let mut list = Vec::new();
    for channel in 0..if inputs.beacon {
        3
    } else {
        usize::from(constraint)
    } {
        for (n, shape) in shapes(inputs).into_iter().enumerate() {
            list.push(Regressor::channel(
                format!("shape {n} on {}", CHANNEL[channel]),
                "m",
                SIZE_M,
                channel,
                shape,
            ));
        }
    }
    if !constraint || !inputs.beacon {
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            for (n, shape) in shapes(inputs).into_iter().enumerate() {
                list.push(Regressor::channel(
                    format!("shape {n} on segment {}", s + 1),
                    "m",
                    SIZE_M,
                    3 + s,
                    shape,
                ));
            }
        }
    }
    list
}

mod shape {
    /// A scalar function of what the sensor knows.
    pub type Shape = Box<dyn Fn(&effects::sensor::Covariates) -> f64 + Send + Sync>;
}
use shape::Shape;

fn time(_: &BasisInputs) -> Vec<Shape> {
    /// Knots over a run. A bound on the work: what bends within a twelfth of it is described no better, and finer shapes are
    /// asked for where nothing is located ([`crate::design::fine_basis`]).
    const COURSE_KNOTS: usize = 13;
    (0..COURSE_KNOTS)
        .map(|k| -> Shape {
            let place = k as f64 / (COURSE_KNOTS - 1) as f64;
            Box::new(move |m| {
                (1.0 - (m.progress - place).abs() * (COURSE_KNOTS - 1) as f64).max(0.0)
            })
        })
        .collect()
}

fn theta(_: &BasisInputs) -> Vec<Shape> {
    // Waves of 4 to 0.9 degrees and a square: what turns with the courier and is not a span.
    let mut list: Vec<Shape> = vec![
        Box::new(|m: &Covariates| m.theta_rad * m.theta_rad),
        Box::new(|m| m.theta_rad.powi(3)),
    ];
    for k in 1..4 {
        let w = 90.0 * f64::from(k);
        list.push(Box::new(move |m| (w * m.theta_rad).sin()));
        list.push(Box::new(move |m| (w * m.theta_rad).cos()));
    }
    list
}

/// Waves longer than what a field of teeth has: 60 mm down to 10 mm, along and across each segment.
fn waves(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| inputs.segments[*s] && inputs.travel_m[*s] > 3.0 * inputs.pitch_m) {
        for direction in 0..if inputs.lateral { 2 } else { 1 } {
            for k in 1..7 {
                let w = TAU * f64::from(k) / 60.0e-3;
                let name = |part| {
                    format!(
                        "{} mm {part}, {}, segment {}",
                        60 / k,
                        ["along", "across"][direction],
                        s + 1
                    )
                };
                list.push(Regressor::reading(name("sine"), "m", SIZE_M, s, move |m| {
                    (w * m.place_m[s][direction]).sin()
                }));
                list.push(Regressor::reading(
                    name("cosine"),
                    "m",
                    SIZE_M,
                    s,
                    move |m| (w * m.place_m[s][direction]).cos(),
                ));
            }
        }
    }
    list
}

fn warmth(_: &BasisInputs) -> Vec<Shape> {
    vec![
        Box::new(|m| m.warmth_k),
        Box::new(|m| m.warmth_k * m.warmth_k),
        Box::new(|m| m.warmth_k.powi(3)),
    ]
}

fn deflection(inputs: &BasisInputs) -> Vec<Shape> {
    let mut list: Vec<Shape> = Vec::new();
    for axis in 0..2 {
        for k in 1..7 {
            let w = TAU * f64::from(k) / 1.5;
            list.push(Box::new(move |m| (w * m.deflection[axis]).sin()));
            list.push(Box::new(move |m| (w * m.deflection[axis]).cos()));
        }
    }
    for &[u, v] in &inputs.deflection_waves {
        let phase = move |m: &Covariates| TAU * (u * m.deflection[0] + v * m.deflection[1]);
        list.push(Box::new(move |m| phase(m).sin()));
        list.push(Box::new(move |m| phase(m).cos()));
    }
    list
}

fn own_orders(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    let f = TAU / inputs.pitch_m;
    for s in (0..4).filter(|s| inputs.segments[*s]) {
        for order in [0.5, 1.5, 2.5, 1.0 / 3.0, 0.2, 0.1] {
            let name = |part| format!("order {order} {part}, segment {}", s + 1);
            list.push(Regressor::reading(name("sine"), "m", SIZE_M, s, move |m| {
                (f * order * m.place_m[s][0]).sin()
            }));
            list.push(Regressor::reading(
                name("cosine"),
                "m",
                SIZE_M,
                s,
                move |m| (f * order * m.place_m[s][0]).cos(),
            ));
        }
    }
    list
}

fn pair_phases(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    let f = TAU / inputs.pitch_m;
    for s in (0..4).filter(|s| inputs.segments[*s] && inputs.segments[(s + 2) % 4]) {
        for (n, m) in [(1.0, 1.0), (2.0, 1.0), (2.0, -1.0), (3.0, 1.0)] {
            let wave = move |at: &Covariates| {
                (f * (n * at.place_m[s][0] + m * at.place_m[(s + 2) % 4][0])).sin_cos()
            };
            let name = |part| format!("orders {n} and {m} {part}, segment {}", s + 1);
            list.push(Regressor::reading(name("sine"), "m", SIZE_M, s, move |m| {
                wave(m).0
            }));
            list.push(Regressor::reading(
                name("cosine"),
                "m",
                SIZE_M,
                s,
                move |m| wave(m).1,
            ));
        }
    }
    list
}

/// Whole orders, on both segments of a pair at once.
fn reference_phase(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    // One segment alone passes the reference's place and its own at different times only where the courier turns.
    let apart = |s: &usize| {
        let in_use = [inputs.segments[*s], inputs.segments[s + 2]];
        in_use == [true; 2] || inputs.turning && in_use.contains(&true)
    };
    for s in (0..2).filter(|s| inputs.reference && apart(s)) {
        for order in 1..9 {
            for (part, quarter) in [("sine", 0.0), ("cosine", 0.25 * TAU)] {
                let wave = move |m: &Covariates| {
                    let phase = 0.5 * (m.reference_phase[s] + m.reference_phase[s + 2]);
                    (f64::from(order) * phase + quarter).sin()
                };
                let name = format!("order {order} {part}, segments {} and {}", s + 1, s + 3);
                list.push(Regressor::readings(name, "m", SIZE_M, move |m, out| {
                    out[s] += wave(m);
                    out[s + 2] += wave(m);
                }));
            }
        }
    }
    list
}

/// What is multiplied by the own tooth phase's orders, of a segment.
trait OfSegment: Fn(&Covariates, usize) -> f64 + Send + Sync + Copy + 'static {}
impl<F: Fn(&Covariates, usize) -> f64 + Send + Sync + Copy + 'static> OfSegment for F {}

fn times(inputs: &BasisInputs, which: Factor, factor: impl OfSegment) -> Vec<Regressor> {
    times_of(inputs.segments, which, factor)
}

fn times_of(segments: [bool; 4], which: Factor, factor: impl OfSegment) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| segments[*s]) {
        for order in [1, 2] {
            let label = ("times ", "1", SIZE_M, which);
            Regressor::harmonic(&mut list, s, order, label, move |m| factor(m, s));
        }
    }
    list
}

fn accelerations(inputs: &BasisInputs) -> Vec<Regressor> {
    (0..4)
        .filter(|s| inputs.segments[*s])
        .map(|s| {
            Regressor::reading(
                format!("acceleration, segment {}", s + 1),
                "s²",
                SIZE_M,
                s,
                move |m| m.acceleration_m_s2[s],
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A beacon that swings at half a hertz would hang by a metre: the line has a place, and no name.
    #[test]
    fn a_slow_line_of_the_beacon_is_no_vibration() {
        let inputs = BasisInputs {
            beacon: true,
            beacon_lines_hz: vec![0.5, 40.0],
            ..BasisInputs::default()
        };
        let sides = effects::sensor_sides();
        let vibration = sides
            .iter()
            .find(|e| e.card().detection == effects::Detection::ByLines);
        let named = vibration.map_or_else(Vec::new, |v| v.regressors(&inputs));
        assert!(!named.is_empty() && named.iter().all(|r| r.name.starts_with("40.000 Hz")));
        let places = coordinate_bases(&inputs);
        let lines = places.iter().find(|p| p.coordinate == "frequency").unwrap();
        assert!(
            lines
                .regressors
                .iter()
                .all(|r| r.name.starts_with("0.500 Hz"))
        );
        assert_eq!(lines.regressors.len(), 4);
    }
}
