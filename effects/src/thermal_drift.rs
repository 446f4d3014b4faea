//! `thermal_drift`: offsets and scale follow temperature.
//!
//! Each coil's mount and electronics drift by their own coefficient (5.6 um/K has been seen on an eddy-current probe); platen
//! and courier grow by 5 to 22 ppm/K.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::segment_offsets;

/// Range of temperature at which the size is stated, kelvin: a warm-up.
const RANGE_K: f64 = 4.0;

/// Plant side. Size: standard deviation of the segments' offsets over a temperature uniform within 0 to 4 K, pooled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalDrift {
    /// Each segment's drift, m/K.
    pub offset_m_per_k: [f64; SEGMENTS],
    /// Curvature: the drift's coefficient changes by this share per kelvin.
    pub curvature_per_k: f64,
    /// Growth of the platen, 1/K.
    pub growth_per_k: f64,
}

impl ThermalDrift {
    /// Offsets normal, a mild curvature, growth in proportion: 5 to 22 ppm/K beside 2 um.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let curvature_per_k = 0.02 * normal(rng);
        // Standard deviation of t + c t^2 over uniform 0..T: moments of a uniform variable.
        let (t, c) = (RANGE_K, curvature_per_k);
        let variance = t * t / 12.0 + c * t.powi(3) / 6.0 + c * c * t.powi(4) * 4.0 / 45.0;
        Box::new(Self {
            offset_m_per_k: segment_offsets(rng, size_rms_m / variance.sqrt()),
            curvature_per_k,
            growth_per_k: uniform(rng, 5.0e-6, 22.0e-6) * size_rms_m / 2.0e-6,
        })
    }
}

impl PlantEffect for ThermalDrift {
    fn scale(&mut self, factor: f64) {
        self.offset_m_per_k = self.offset_m_per_k.map(|c| c * factor);
        self.growth_per_k *= factor;
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        // A grown ruling has fewer pitches to the same place.
        let shrink = 1.0 - self.growth_per_k * at.temperature_delta_k;
        for point in points {
            point.own_m *= shrink;
            point.across_m *= shrink;
        }
    }

    fn displacement_m(&mut self, at: &Instant, _points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let warm = at.temperature_delta_k * (1.0 + self.curvature_per_k * at.temperature_delta_k);
        self.offset_m_per_k.map(|c| c * warm)
    }
}
