//! offset, gain or phase of a quadrature pair wander with time.
// --- sensor side: orders one and two of the own phase that wander with time ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: offset (order 1), gain and phase (order 2 and a constant) as piecewise linear functions of time.
pub struct WanderModel;

/// Knots over the recording.
const KNOTS: usize = 9;

impl SensorEffect for WanderModel {
    fn name(&self) -> &'static str {
        "quadrature_drift"
    }

    fn sentence(&self) -> &'static str {
        "offset, gain or phase of a quadrature pair wander with time"
    }

    fn telling_motion(&self) -> &'static str {
        "the same fly-by repeated over an hour at a constant temperature"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s]) {
            for knot in 0..KNOTS {
                let place = knot as f64 / (KNOTS - 1) as f64;
                let hat = move |m: &effects::sensor::Moment| {
                    (1.0 - (m.progress - place).abs() * (KNOTS - 1) as f64).max(0.0)
                };
                let label = format!("at {:.0} % of the time, ", 100.0 * place);
                for order in [1, 2] {
                    Regressor::harmonic(&mut list, s, order, (&label, "m", 3.0e-6), hat);
                }
            }
        }
        list
    }
}
