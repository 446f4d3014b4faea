//! The interferometer's mirror creeps with temperature: an error of the reference, not of the courier.

use crate::motion::Pose;
use crate::plant::{Instant, PlantEffect, Scene};
use crate::random::{ChaCha8Rng, normal};

/// Size: standard deviation of a reference coordinate over a temperature uniform within 0 to 4 K, pooled over x and y.
pub struct ReferenceMirror {
    drift_m_per_k: [f64; 2],
    turn_rad_per_k: f64,
}

impl ReferenceMirror {
    /// Each axis' own mount.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let raw: [f64; 2] = [(); 2].map(|()| normal(rng));
        let unit = size_rms_m * 12.0_f64.sqrt() / 4.0 / (0.5 * (raw[0] * raw[0] + raw[1] * raw[1])).sqrt().max(1.0e-9);
        // A mirror of 50 mm that creeps at one end turns by so much.
        let turn_rad_per_k = unit * normal(rng) / 50.0e-3;
        Box::new(Self { drift_m_per_k: raw.map(|r| r * unit), turn_rad_per_k })
    }
}

impl PlantEffect for ReferenceMirror {
    fn scale(&mut self, factor: f64) {
        self.drift_m_per_k = self.drift_m_per_k.map(|d| d * factor);
        self.turn_rad_per_k *= factor;
    }

    fn reference(&mut self, at: &Instant, pose: &mut Pose) {
        pose.x_m += self.drift_m_per_k[0] * at.temperature_delta_k;
        pose.y_m += self.drift_m_per_k[1] * at.temperature_delta_k;
        pose.theta_rad += self.turn_rad_per_k * at.temperature_delta_k;
    }
}
