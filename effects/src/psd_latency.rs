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
