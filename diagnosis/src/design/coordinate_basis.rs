//! Shapes that no catalogued effect owns: where a gap lies when nothing known explains it, and what every cause must beat.

use crate::design::frequency_basis::lines;
use crate::design::nameless::{CHANNEL, SIZE_M};
use effects::sensor::{Action, Moment, Regressor, Survey};
use std::f64::consts::TAU;

/// A family of shapes over one coordinate of diagnosis.md.
pub struct Place {
    /// The coordinate, in the words of diagnosis.md.
    pub coordinate: &'static str,
    /// Shapes over it.
    pub regressors: Vec<Regressor>,
}

/// Where a periodic error of the reference itself lies: at its own place and not at a segment's, the same for both of a pair.
pub const REFERENCE_PHASE: &str = "own tooth phase of the reference";

/// Every family that such a recording can show.
pub fn places(survey: &Survey) -> Vec<Place> {
    let mut list = vec![
        Place {
            coordinate: "time",
            regressors: on_channels(survey, time),
        },
        Place {
            coordinate: "theta",
            regressors: if survey.turning {
                on_channels(survey, theta)
            } else {
                Vec::new()
            },
        },
        Place {
            coordinate: "place on the platen",
            regressors: waves(survey),
        },
        Place {
            coordinate: "own tooth phase, fractional orders",
            regressors: own_orders(survey),
        },
        Place {
            coordinate: "own tooth phase of both segments of a pair",
            regressors: pair_phases(survey),
        },
        Place {
            coordinate: REFERENCE_PHASE,
            regressors: reference_phase(survey),
        },
        Place {
            coordinate: "frequency",
            regressors: lines(survey),
        },
    ];
    if survey.temperature {
        list.push(Place {
            coordinate: "temperature",
            regressors: on_channels(survey, warmth),
        });
        list.push(Place {
            coordinate: "temperature and own tooth phase",
            regressors: times(survey, |m, _| m.warmth_k),
        });
    }
    if survey.moving {
        list.push(Place {
            coordinate: "speed",
            regressors: accelerations(survey),
        });
        list.push(Place {
            coordinate: "speed and own tooth phase",
            regressors: times(survey, |m, s| m.speed_m_s[s])
                .into_iter()
                .chain(times(survey, |m, s| m.acceleration_m_s2[s]))
                .collect(),
        });
        list.push(Place {
            coordinate: "direction and own tooth phase",
            regressors: times(survey, |m, s| m.direction[s]),
        });
    }
    if survey.counts {
        // Where the place explains the amplitude it is gap_variation's; what else changes it has no name.
        let nameless = std::array::from_fn(|s| survey.segments[s] && !survey.amplitude_by_place[s]);
        list.push(Place {
            coordinate: "signal amplitude",
            regressors: times_of(nameless, |m, s| m.amplitude_excess[s]),
        });
    }
    if survey.beacon {
        list.push(Place {
            coordinate: "deflection of the coordination sensor",
            regressors: on_channels(survey, deflection),
        });
    }
    list.retain(|place| !place.regressors.is_empty());
    list
}

/// The same shapes on every channel that the recording has.
fn on_channels(survey: &Survey, shapes: fn(&Survey) -> Vec<Shape>) -> Vec<Regressor> {
    let constraint = survey.segments.iter().all(|s| *s);
    let mut list = Vec::new();
    for channel in 0..if survey.beacon {
        3
    } else {
        usize::from(constraint)
    } {
        for (n, shape) in shapes(survey).into_iter().enumerate() {
            list.push(Regressor::channel(
                format!("shape {n} on {}", CHANNEL[channel]),
                "m",
                SIZE_M,
                channel,
                shape,
            ));
        }
    }
    if !constraint || !survey.beacon {
        for s in (0..4).filter(|s| survey.segments[*s]) {
            for (n, shape) in shapes(survey).into_iter().enumerate() {
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
    pub type Shape = Box<dyn Fn(&effects::sensor::Moment) -> f64 + Send + Sync>;
}
use shape::Shape;

fn time(_: &Survey) -> Vec<Shape> {
    const KNOTS: usize = 13;
    (0..KNOTS)
        .map(|k| -> Shape {
            let place = k as f64 / (KNOTS - 1) as f64;
            Box::new(move |m| (1.0 - (m.progress - place).abs() * (KNOTS - 1) as f64).max(0.0))
        })
        .collect()
}

fn theta(_: &Survey) -> Vec<Shape> {
    // Waves of 4 to 0.9 degrees and a square: what turns with the courier and is not a span.
    let mut list: Vec<Shape> = vec![
        Box::new(|m: &Moment| m.theta_rad * m.theta_rad),
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
fn waves(survey: &Survey) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| survey.segments[*s] && survey.travel_m[*s] > 3.0 * survey.pitch_m) {
        for direction in 0..if survey.lateral { 2 } else { 1 } {
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

fn warmth(_: &Survey) -> Vec<Shape> {
    vec![
        Box::new(|m| m.warmth_k),
        Box::new(|m| m.warmth_k * m.warmth_k),
        Box::new(|m| m.warmth_k.powi(3)),
    ]
}

fn deflection(survey: &Survey) -> Vec<Shape> {
    let mut list: Vec<Shape> = Vec::new();
    for axis in 0..2 {
        for k in 1..7 {
            let w = TAU * f64::from(k) / 1.5;
            list.push(Box::new(move |m| (w * m.deflection[axis]).sin()));
            list.push(Box::new(move |m| (w * m.deflection[axis]).cos()));
        }
    }
    for &[u, v] in &survey.deflection_waves {
        let phase = move |m: &Moment| TAU * (u * m.deflection[0] + v * m.deflection[1]);
        list.push(Box::new(move |m| phase(m).sin()));
        list.push(Box::new(move |m| phase(m).cos()));
    }
    list
}

fn own_orders(survey: &Survey) -> Vec<Regressor> {
    let mut list = Vec::new();
    let f = TAU / survey.pitch_m;
    for s in (0..4).filter(|s| survey.segments[*s]) {
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

fn pair_phases(survey: &Survey) -> Vec<Regressor> {
    let mut list = Vec::new();
    let f = TAU / survey.pitch_m;
    for s in (0..4).filter(|s| survey.segments[*s] && survey.segments[(s + 2) % 4]) {
        for (n, m) in [(1.0, 1.0), (2.0, 1.0), (2.0, -1.0), (3.0, 1.0)] {
            let wave = move |at: &Moment| {
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
fn reference_phase(survey: &Survey) -> Vec<Regressor> {
    let mut list = Vec::new();
    // One segment alone passes the reference's place and its own at different times only where the courier turns.
    let apart = |s: &usize| {
        let in_use = [survey.segments[*s], survey.segments[s + 2]];
        in_use == [true; 2] || survey.turning && in_use.contains(&true)
    };
    for s in (0..2).filter(|s| survey.reference && apart(s)) {
        for order in 1..9 {
            for (part, quarter) in [("sine", 0.0), ("cosine", 0.25 * TAU)] {
                let wave = move |m: &Moment| {
                    let phase = 0.5 * (m.reference_phase[s] + m.reference_phase[s + 2]);
                    (f64::from(order) * phase + quarter).sin()
                };
                list.push(Regressor {
                    name: format!("order {order} {part}, segments {} and {}", s + 1, s + 3),
                    unit: "m",
                    size_m: SIZE_M,
                    deviation: None,
                    mean: 0.0,
                    during: effects::sensor::ALWAYS,
                    over: None,
                    course: None,
                    identity: None,
                    action: Action::Readings(Box::new(move |m, out| {
                        out[s] += wave(m);
                        out[s + 2] += wave(m);
                    })),
                });
            }
        }
    }
    list
}

fn times(survey: &Survey, factor: fn(&Moment, usize) -> f64) -> Vec<Regressor> {
    times_of(survey.segments, factor)
}

fn times_of(segments: [bool; 4], factor: fn(&Moment, usize) -> f64) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| segments[*s]) {
        for order in [1, 2] {
            Regressor::harmonic(&mut list, s, order, ("times ", "1", SIZE_M), move |m| {
                factor(m, s)
            });
        }
    }
    list
}

fn accelerations(survey: &Survey) -> Vec<Regressor> {
    (0..4)
        .filter(|s| survey.segments[*s])
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
        let survey = Survey {
            beacon: true,
            beacon_lines_hz: vec![0.5, 40.0],
            ..Survey::default()
        };
        let sides = effects::sensor_sides();
        let vibration = sides
            .iter()
            .find(|e| e.card().judged == effects::Judged::ByLines);
        let named = vibration.map_or_else(Vec::new, |v| v.regressors(&survey));
        assert!(!named.is_empty() && named.iter().all(|r| r.name.starts_with("40.000 Hz")));
        let places = places(&survey);
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
