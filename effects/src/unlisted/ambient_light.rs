//! A lamp is switched on: every electrode gets its share of it, the deflection shrinks and shifts.

use crate::plant::{Channels, Instant, PlantEffect, Scene};
use crate::random::{ChaCha8Rng, uniform};

/// Size: displacement that the step makes at a deflection of 0.5, rms of the two axes.
pub struct AmbientLight {
    /// From when on, seconds.
    from_s: f64,
    /// Each electrode's share of an axis' sum.
    shares: [f64; 4],
}

impl AmbientLight {
    /// Unevenly spread, on from the middle of the recording.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let shares = [(); 4].map(|()| uniform(rng, 0.3, 1.0));
        // Normalised shift of an axis at deflection u by shares a, b of the sum: a - b - u (a + b).
        let shift = |a: f64, b: f64| a - b - 0.5 * (a + b);
        let rms = (0.5 * (shift(shares[0], shares[1]).powi(2) + shift(shares[2], shares[3]).powi(2))).sqrt();
        let full_m = scene.geometry.height_m * scene.geometry.tan_full_scale;
        let mut effect = Self { from_s: scene.duration_s * uniform(rng, 0.3, 0.7), shares };
        effect.scale(size_rms_m / (full_m * rms.max(0.05)));
        Box::new(effect)
    }
}

impl PlantEffect for AmbientLight {
    fn scale(&mut self, factor: f64) {
        self.shares = self.shares.map(|share| share * factor);
    }

    fn analog(&mut self, at: &Instant, channels: &mut Channels) {
        if at.time_s < self.from_s {
            return;
        }
        for (value, share) in channels.electrodes.iter_mut().zip(self.shares) {
            *value += share * channels.psd_sum_counts;
        }
    }
}
