//! `extra_harmonics`: orders of the own tooth phase that equation (3) leaves out.
//!
//! Tooth shape, coil spacing and the drive's saturation make every order; equation (3) kept the four that one device showed.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};
use crate::shape::{Periodic, segment_sizes};

/// Orders that are drawn, with their relative weights.
const ORDERS: [(usize, f64); 8] =
    [(3, 1.0), (5, 0.8), (7, 0.4), (8, 0.8), (9, 0.3), (10, 0.4), (12, 0.4), (16, 0.15)];

/// Plant side. Size: rms over the own phase, pooled over the segments.
pub struct ExtraHarmonics {
    shapes: [Periodic; SEGMENTS],
    sizes_m: [f64; SEGMENTS],
}

impl ExtraHarmonics {
    /// Every segment has its own shape.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let shapes = core::array::from_fn(|_| {
            let weights = ORDERS.map(|(order, weight)| (order, weight * normal(rng).abs()));
            Periodic::draw(rng, &weights)
        });
        Box::new(Self { shapes, sizes_m: segment_sizes(rng, size_rms_m) })
    }
}

impl PlantEffect for ExtraHarmonics {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| self.sizes_m[s] * self.shapes[s].at(points[s].own_m / at.geometry.pitch_m))
    }
}

// --- sensor side: orders of the own phase that equation (3) leaves out ---

pub use sensor_side::HarmonicsModel;

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{ORDERS, Regressor, SensorEffect, Survey};

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
                    Regressor::free_harmonic(survey, &mut list, (s, order), ("", "m", 2.0e-6), |_| 1.0);
                }
            }
            list
        }
    }
}
