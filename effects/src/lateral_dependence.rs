//! `lateral_dependence`: a segment's output depends on the tooth phase across it.
//!
//! A coil pair is a few teeth wide; as it slides across the rows of posts its coupling changes with the pitch. Mostly the
//! first order of the lateral phase (equation 9), a second order, and products with the own phase, since the coupling is
//! that of single posts and not of lines.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};

/// `(own order, lateral order, relative weight)`: what is drawn for each segment.
const ORDERS: [(f64, f64, f64); 6] = [
    (0.0, 1.0, 1.0),
    (0.0, 2.0, 0.35),
    (0.0, 3.0, 0.08),
    (1.0, 1.0, 0.15),
    (1.0, -1.0, 0.15),
    (2.0, 1.0, 0.08),
];

/// One wave over own and lateral phase: `amplitude * sin(own n + lateral m + offset)`, as sine and cosine parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralWave {
    /// Order of the own tooth phase.
    pub own_order: f64,
    /// Order of the lateral tooth phase, signed.
    pub lateral_order: f64,
    /// Sine and cosine amplitudes, metres.
    pub amplitude_m: [f64; 2],
}

impl LateralWave {
    fn at(&self, wavenumber: f64, point: &SegmentPoint) -> f64 {
        let phase =
            wavenumber * (self.own_order * point.own_m + self.lateral_order * point.across_m);
        let (sine, cosine) = phase.sin_cos();
        self.amplitude_m[0] * sine + self.amplitude_m[1] * cosine
    }
}

/// Plant side. Size: rms over own and lateral phase, pooled over the four segments.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralDependence {
    /// Each segment's waves.
    pub waves: [Vec<LateralWave>; SEGMENTS],
}

impl LateralDependence {
    /// Amplitudes of all orders are normal, so that segments differ as built ones do.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let waves = core::array::from_fn(|_| {
            let wave = |&(own_order, lateral_order, weight): &(f64, f64, f64)| LateralWave {
                own_order,
                lateral_order,
                amplitude_m: [weight * normal(rng), weight * normal(rng)],
            };
            ORDERS.iter().map(wave).collect()
        });
        let mut effect = Self { waves };
        let rms = effect.rms_m();
        effect.scale(size_rms_m / rms);
        Box::new(effect)
    }

    /// Rms over uniform phases, pooled over the segments: orders are orthogonal, so powers add.
    #[must_use]
    pub fn rms_m(&self) -> f64 {
        let power: f64 = self
            .waves
            .iter()
            .flatten()
            .flat_map(|wave| wave.amplitude_m)
            .map(|a| 0.5 * a * a)
            .sum();
        (power / SEGMENTS as f64).sqrt()
    }
}

impl PlantEffect for LateralDependence {
    fn scale(&mut self, factor: f64) {
        self.waves
            .iter_mut()
            .flatten()
            .for_each(|wave| wave.amplitude_m = wave.amplitude_m.map(|a| a * factor));
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        let wavenumber = at.geometry.wavenumber();
        core::array::from_fn(|s| {
            self.waves[s]
                .iter()
                .map(|wave| wave.at(wavenumber, &points[s]))
                .sum()
        })
    }
}
