//! orders of the own tooth phase that equation (3) leaves out; a shape, not a cause.
// --- sensor side: orders of the own phase that equation (3) leaves out ---

use effects::sensor::{ORDERS, Regressor, SensorEffect, Survey};

/// Sensor side: free sine and cosine of each order, each segment by itself.
pub struct HarmonicsModel;

/// Orders that equation (3) has.
const KNOWN: [usize; 4] = [1, 2, 4, 6];

impl SensorEffect for HarmonicsModel {
    fn name(&self) -> &'static str {
        "extra_harmonics"
    }

    fn sentence(&self) -> &'static str {
        "orders of the own tooth phase that equation (3) leaves out; a shape, not a cause"
    }

    fn telling_motion(&self) -> &'static str {
        "raw counts instead of positions: clipping and gap variation show in the amplitude, free harmonics do not"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s]) {
            for order in (3..=ORDERS).filter(|n| !KNOWN.contains(n)) {
                Regressor::harmonic(&mut list, s, order, ("", "m", 2.0e-6), |_| 1.0);
            }
        }
        list
    }
}
