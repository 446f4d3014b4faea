//! A converter bit sticks on one pair's channels: codes are missing at regular places.

use crate::plant::{Codes, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, index};

/// Size: rms of the displacement, pooled over the segments; whole codes, so near to what was asked for.
pub struct MissingCodes {
    segment: usize,
    step_counts: f64,
}

impl MissingCodes {
    /// One pair.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        // Rounding to a step q makes q / sqrt(12) a channel and so of the phase; one pair of four.
        let step_counts = 2.0 * size_rms_m * scene.counts_per_m() * 12.0_f64.sqrt();
        Box::new(Self { segment: index(rng, SEGMENTS), step_counts })
    }
}

impl PlantEffect for MissingCodes {
    fn scale(&mut self, factor: f64) {
        self.step_counts *= factor;
    }

    fn codes(&mut self, _at: &Instant, codes: &mut Codes) {
        let step = self.step_counts.max(1.0);
        for code in &mut codes.quadrature[self.segment] {
            *code = ((f64::from(*code) / step).round() * step).round() as i16;
        }
    }
}
