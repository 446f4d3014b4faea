//! the diode of the coordination sensor is turned in its mount, or its axes differ in gain.
// --- sensor side: a turn of the diode and a difference of gain ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: two amounts. A pure turn is tied to the platen sensor's own zero of angle by the prior on the offsets.
pub struct MountingModel;

impl SensorEffect for MountingModel {
    fn name(&self) -> &'static str {
        "psd_misalignment"
    }

    fn sentence(&self) -> &'static str {
        "the diode of the coordination sensor is turned in its mount, or its axes differ in gain"
    }

    fn telling_motion(&self) -> &'static str {
        "a known distance by an independent reference along both axes: only it tells the diode's gain from the platen's pitch"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        if !survey.beacon {
            return Vec::new();
        }
        vec![
            Regressor::readings("gain of x over y", "1", 4.0e-6, |m, out| {
                out[4] += 0.5 * m.tan_psi[0];
                out[5] -= 0.5 * m.tan_psi[1];
            }),
            Regressor::readings("turn in the mount", "rad", 10.0e-6, |m, out| {
                out[4] -= m.tan_psi[1];
                out[5] += m.tan_psi[0];
            }),
        ]
    }
}
