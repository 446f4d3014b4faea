//! a segment's output lags with its speed: eddy currents, filter or sampling delay.
// --- sensor side: each segment's own speed ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: a delay of each segment, and a part that grows with the square of speed.
pub struct LagModel;

impl SensorEffect for LagModel {
    fn name(&self) -> &'static str {
        "velocity_lag"
    }

    fn sentence(&self) -> &'static str {
        "a segment's output lags with its speed: eddy currents, filter or sampling delay"
    }

    fn telling_motion(&self) -> &'static str {
        "fly-bys at several speeds, with samples while the speed changes"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s] && survey.moving) {
            let name = format!("delay, segment {}", s + 1);
            list.push(Regressor::reading(name, "s", 5.0e-6, s, move |m| {
                m.speed_m_s[s]
            }));
            let name = format!("square of speed, segment {}", s + 1);
            list.push(Regressor::reading(name, "s²/m", 1.0e-6, s, move |m| {
                m.speed_m_s[s] * m.speed_m_s[s].abs()
            }));
        }
        list
    }
}
