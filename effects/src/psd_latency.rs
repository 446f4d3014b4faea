//! `psd_latency`: the coordination sensor is sampled earlier or later than the platen sensor.

// --- plant side: the time at which the diode is read ---

use crate::plant::{PlantEffect, Scene};
use crate::random::{ChaCha8Rng, sign};

/// Speed at which the size is stated: the sweeps' under the beacon.
const REFERENCE_M_S: f64 = 20.0e-3;

/// Plant side. Size: displacement within the delay at 20 mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PsdLatency {
    /// How much later than the platen sensor it is sampled, seconds; negative: earlier.
    pub delay_s: f64,
}

impl PsdLatency {
    /// Either sign.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Box::new(Self { delay_s: sign(rng) * size_rms_m / REFERENCE_M_S })
    }
}

impl PlantEffect for PsdLatency {
    fn scale(&mut self, factor: f64) {
        self.delay_s *= factor;
    }

    fn coordination_delay_s(&self) -> f64 {
        self.delay_s
    }
}

// --- sensor side: the deflection's rate ---

pub use sensor_side::LatencyModel;

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{Regressor, SensorEffect, Survey};

    /// Sensor side: one delay, common to both axes, and how far one lags behind the other: no more than completes it, as their filters
    /// are alike.
    pub struct LatencyModel;

    impl SensorEffect for LatencyModel {
        fn name(&self) -> &'static str {
            "psd_latency"
        }

        fn sentence(&self) -> &'static str {
            "the coordination sensor is sampled earlier or later than the platen sensor"
        }

        fn telling_motion(&self) -> &'static str {
            "fly-bys under the beacon at several speeds, along x and along y; a delay common to all four segments stays the same thing"
        }

        fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
            if !survey.beacon || !survey.moving {
                return Vec::new();
            }
            vec![
                Regressor::readings("delay against the platen sensor", "s", 5.0e-6, |m, out| {
                    out[4] += m.tan_psi_rate[0];
                    out[5] += m.tan_psi_rate[1];
                }),
                Regressor::readings("delay of x over y", "s", 1.0e-6, |m, out| {
                    out[4] += 0.5 * m.tan_psi_rate[0];
                    out[5] -= 0.5 * m.tan_psi_rate[1];
                }),
            ]
        }
    }
}
