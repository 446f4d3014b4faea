//! the segments do not sit where the drawing says.
// --- sensor side: the angle in g_p ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: the two pairs' distances differ; a common error is the lever arms' scale and unseen.
pub struct SpanModel;

impl SensorEffect for SpanModel {
    fn name(&self) -> &'static str {
        "span_error"
    }

    fn sentence(&self) -> &'static str {
        "the segments do not sit where the drawing says"
    }

    fn telling_motion(&self) -> &'static str {
        "slow turns over ±1.2° at one place"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        if !survey.turning || !survey.segments.iter().all(|s| *s) {
            return Vec::new();
        }
        vec![Regressor::readings(
            "span of segments 1 and 3 over 2 and 4",
            "m",
            5.0e-6,
            |m, out| {
                for (s, sign) in [1.0, -1.0, -1.0, 1.0].into_iter().enumerate() {
                    out[s] += 0.25 * sign * m.theta_rad;
                }
            },
        )]
    }
}
