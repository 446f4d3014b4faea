//! the coordination sensor's output bends with its deflection: cubic, quadratic and cross terms.
// --- sensor side: quadratic, cross and cubic terms of the deflection ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: all terms of second and third degree in the two deflections.
pub struct DeflectionModel;

/// Powers of the deflections along x and y.
const POWERS: [[i32; 2]; 7] = [[3, 0], [0, 3], [2, 1], [1, 2], [2, 0], [1, 1], [0, 2]];

impl SensorEffect for DeflectionModel {
    fn name(&self) -> &'static str {
        "psd_nonlinearity"
    }

    fn sentence(&self) -> &'static str {
        "the coordination sensor's output bends with its deflection: cubic, quadratic and cross terms"
    }

    fn telling_motion(&self) -> &'static str {
        "fly-bys under the beacon along both axes to the edge of the diode"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for axis in (0..2).filter(|_| survey.beacon) {
            for [a, b] in POWERS {
                let full = survey.tan_full_scale;
                let name = format!("x^{a} y^{b} on {}", ["x", "y"][axis]);
                list.push(Regressor::reading(
                    name,
                    "of full scale",
                    4.0e-6,
                    4 + axis,
                    move |m| full * m.deflection[0].powi(a) * m.deflection[1].powi(b),
                ));
            }
        }
        list
    }
}
