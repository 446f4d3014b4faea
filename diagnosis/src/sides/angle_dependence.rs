//! the error's harmonics change with the courier's angle.
// --- sensor side: harmonics times powers of the angle ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: each low order times theta and theta squared.
pub struct AngleModel;

impl SensorEffect for AngleModel {
    fn name(&self) -> &'static str {
        "angle_dependence"
    }

    fn sentence(&self) -> &'static str {
        "the error's harmonics change with the courier's angle"
    }

    fn telling_motion(&self) -> &'static str {
        "random still poses with the angle over ±1.5°"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s] && survey.turning) {
            for order in [1, 2, 3, 4, 6] {
                let size_m = if order < 3 { 2.5e-6 } else { 1.5e-6 };
                Regressor::harmonic(
                    &mut list,
                    s,
                    order,
                    ("theta times ", "m/rad", size_m),
                    |m| m.theta_rad,
                );
                Regressor::harmonic(
                    &mut list,
                    s,
                    order,
                    ("theta squared times ", "m/rad²", 0.7e-6),
                    |m| m.theta_rad * m.theta_rad,
                );
            }
        }
        list
    }
}
