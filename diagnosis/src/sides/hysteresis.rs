//! a segment's output depends on the direction of travel, not on the speed.
// --- sensor side: direction of travel ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: the direction while moving, and that of the approach while still.
pub struct DirectionModel;

/// Speeds below which the direction may act less than fully, of the highest.
const SOFT: [f64; 3] = [0.006, 0.02, 0.06];

impl SensorEffect for DirectionModel {
    fn name(&self) -> &'static str {
        "hysteresis"
    }

    fn sentence(&self) -> &'static str {
        "a segment's output depends on the direction of travel, not on the speed"
    }

    fn telling_motion(&self) -> &'static str {
        "the same fly-by there and back at two speeds"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s]) {
            if survey.moving {
                let name = format!("direction of travel, segment {}", s + 1);
                list.push(Regressor::reading(name, "m", 4.0e-6, s, move |m| {
                    m.direction[s]
                }));
                for part in SOFT {
                    let soft_m_s = part * survey.top_speed_m_s[s].max(1e-9);
                    let name = format!("softened below {soft_m_s:.1e} m/s, segment {}", s + 1);
                    list.push(Regressor::reading(name, "m", 1.5e-6, s, move |m| {
                        (m.speed_m_s[s] / soft_m_s).tanh()
                    }));
                }
            }
            let name = format!("direction of approach, segment {}", s + 1);
            list.push(Regressor::reading(name, "m", 3.0e-6, s, move |m| {
                m.approach[s]
            }));
        }
        list
    }
}
