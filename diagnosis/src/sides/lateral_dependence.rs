//! a segment's output depends on the tooth phase across it.
// --- sensor side: regressors over the lateral phase ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: equation (9) with orders 1 to 3 across, and products of low orders along and across.
pub struct LateralModel;

impl SensorEffect for LateralModel {
    fn name(&self) -> &'static str {
        "lateral_dependence"
    }

    fn sentence(&self) -> &'static str {
        "a segment's output depends on the tooth phase across it"
    }

    fn telling_motion(&self) -> &'static str {
        "random poses under a beacon with the angle over ±1.5°, which part the tooth phase across a segment from that along its neighbours"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s] && survey.lateral) {
            for (order, size_m) in [(1, 4.0e-6), (2, 2.0e-6), (3, 0.5e-6)] {
                let name = |part| format!("order {order} {part}, segment {}", s + 1);
                list.push(Regressor::reading(name("sine"), "m", size_m, s, move |m| {
                    m.lateral[s][order].0
                }));
                list.push(Regressor::reading(
                    name("cosine"),
                    "m",
                    size_m,
                    s,
                    move |m| m.lateral[s][order].1,
                ));
            }
            for (own, sign) in [(1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
                let name = |part| {
                    format!(
                        "own order {own}, lateral order {sign} {part}, segment {}",
                        s + 1
                    )
                };
                let wave = move |m: &effects::sensor::Moment| {
                    let ((a, b), (c, d)) = (m.own[s][own], m.lateral[s][1]);
                    (a * d + sign * b * c, b * d - sign * a * c)
                };
                list.push(Regressor::reading(name("sine"), "m", 0.7e-6, s, move |m| {
                    wave(m).0
                }));
                list.push(Regressor::reading(
                    name("cosine"),
                    "m",
                    0.7e-6,
                    s,
                    move |m| wave(m).1,
                ));
            }
        }
        list
    }
}
