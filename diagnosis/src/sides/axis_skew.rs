//! the platen's two rulings differ in pitch, or are not square.
// --- sensor side: a difference of pitch and a skew of the two rulings ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: two amounts; a common scale is the beacon's height.
pub struct RulingModel;

impl SensorEffect for RulingModel {
    fn name(&self) -> &'static str {
        "axis_skew"
    }

    fn sentence(&self) -> &'static str {
        "the platen's two rulings differ in pitch, or are not square"
    }

    fn telling_motion(&self) -> &'static str {
        "a known distance by an independent reference along both axes: only it tells the platen's pitch from the diode's gain"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        if !survey.lateral || !survey.segments.iter().all(|s| *s) {
            return Vec::new();
        }
        vec![
            Regressor::readings("pitch of x over y", "1", 3.0e-6, |m, out| {
                for s in 0..4 {
                    let sign = if s % 2 == 0 { 0.5 } else { -0.5 };
                    out[s] += sign * m.place_m[s][0];
                }
            }),
            Regressor::readings("out of square", "rad", 3.0e-6, |m, out| {
                for s in [0, 2] {
                    out[s] += m.centre_m[1];
                }
            }),
        ]
    }
}
