//! offset, gain or phase of a quadrature pair wander with time.
// --- sensor side: orders one and two of the own phase that wander with time ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: offset (order 1), gain and phase (order 2 and a constant) as cubic splines of time.
pub struct WanderModel;

/// Knots over the recording.
const KNOTS: usize = 15;

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
        for s in
            (0..4).filter(|s| survey.segments[*s] && survey.travel_m[*s] > 3.0 * survey.pitch_m)
        {
            for knot in 0..KNOTS {
                // Uniform cubic B-splines that reach one knot past both ends.
                let step = 1.0 / (KNOTS - 3) as f64;
                let place = (knot as f64 - 1.0) * step;
                let hat = move |m: &effects::sensor::Moment| spline((m.progress - place) / step);
                let label = format!("at {:.0} % of the time, ", 100.0 * place);
                for order in [1, 2] {
                    Regressor::harmonic(&mut list, s, order, (&label, "m", 3.0e-6), hat);
                }
            }
        }
        list
    }
}

/// Uniform cubic B-spline with knots a unit apart, centred at zero.
fn spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        2.0 / 3.0 - x * x + 0.5 * x * x * x
    } else if x < 2.0 {
        (2.0 - x).powi(3) / 6.0
    } else {
        0.0
    }
}
