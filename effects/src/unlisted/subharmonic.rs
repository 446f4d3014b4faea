//! Every other tooth differs, as an etching mask of two exposures makes it: orders 1/2 and 3/2 of the pitch.

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::ChaCha8Rng;
use crate::shape::{Periodic, segment_sizes};

/// Size: rms over two pitches, pooled over the segments.
pub struct Subharmonic {
    shapes: [Periodic; SEGMENTS],
    sizes_m: [f64; SEGMENTS],
}

impl Subharmonic {
    /// Mostly the half order.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let shapes = core::array::from_fn(|_| Periodic::draw(rng, &[(1, 1.0), (3, 0.4), (5, 0.1)]));
        Box::new(Self { shapes, sizes_m: segment_sizes(rng, size_rms_m) })
    }
}

impl PlantEffect for Subharmonic {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| self.sizes_m[s] * self.shapes[s].at(0.5 * points[s].own_m / at.geometry.pitch_m))
    }
}
