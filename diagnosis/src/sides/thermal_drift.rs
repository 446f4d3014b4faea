//! offsets and scale follow the board's temperature.
// --- sensor side: offsets and scales times temperature ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: each segment's offset, the scale of both axes, and the coordination sensor's offset and gain.
pub struct WarmthModel;

impl SensorEffect for WarmthModel {
    fn name(&self) -> &'static str {
        "thermal_drift"
    }

    fn sentence(&self) -> &'static str {
        "offsets and scale follow the board's temperature"
    }

    fn telling_motion(&self) -> &'static str {
        "the same poses at two temperatures, and again at the first"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        if !survey.temperature {
            return list;
        }
        for s in (0..4).filter(|s| survey.segments[*s]) {
            let name = format!("offset, segment {}", s + 1);
            list.push(Regressor::reading(name, "m/K", 4.0e-6, s, |m| m.warmth_k));
            let name = format!("offset, second order, segment {}", s + 1);
            list.push(Regressor::reading(name, "m/K²", 0.7e-6, s, |m| {
                m.warmth_k * m.warmth_k
            }));
        }
        for axis in 0..2 {
            let label = ["x", "y"][axis];
            list.push(Regressor::readings(
                format!("scale of {label}"),
                "1/K",
                4.0e-6,
                move |m, out| {
                    for s in [axis, axis + 2] {
                        out[s] += m.warmth_k * m.centre_m[axis];
                    }
                },
            ));
            if survey.beacon {
                let name = format!("coordination sensor's offset {label}");
                list.push(Regressor::reading(name, "1/K", 2.0e-6, 4 + axis, |m| {
                    m.warmth_k
                }));
                let name = format!("coordination sensor's gain {label}");
                list.push(Regressor::reading(
                    name,
                    "1/K",
                    2.0e-6,
                    4 + axis,
                    move |m| m.warmth_k * m.tan_psi[axis],
                ));
            }
        }
        list
    }
}
