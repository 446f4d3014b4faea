//! `quadrature_drift`: offset, gain or phase of a pair wander with time.

// --- plant side: from ideal to real signals ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, Signal};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::{Wander, segment_sizes};

/// One pair's wandering flaws, in units of the pair's size.
struct Pair {
    /// Offset of sine, offset of cosine, gain mismatch, angle.
    weights: [f64; 4],
    wanders: [Wander; 4],
}

/// Plant side. Size: rms over the phase and the recording's duration, pooled over the segments.
pub struct QuadratureDrift {
    pairs: [Pair; SEGMENTS],
    /// Each pair's rms phase error, radians.
    sizes_rad: [f64; SEGMENTS],
}

impl QuadratureDrift {
    /// Offsets, gain or angle in random shares: what an amplifier's bias, its gain or its filter drift by.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let pairs = core::array::from_fn(|_| {
            let shares = [uniform(rng, 0.2, 1.0), uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.6)];
            let raw = [shares[0] * normal(rng), shares[0] * normal(rng), 2.0 * shares[1] * normal(rng), shares[2] * normal(rng)];
            // First order: offset o: o cos or o sin; gain g: (g/2) sin 2 phi; angle a: (a/2)(1 - cos 2 phi).
            let [sine, cosine, gain, angle] = raw.map(|w| w * w);
            let rms = (0.5 * (sine + cosine) + gain / 8.0 + angle * 1.5 / 4.0).sqrt().max(1.0e-9);
            let wanders = core::array::from_fn(|_| Wander::draw(rng, scene.duration_s));
            Pair { weights: raw.map(|w| w / rms), wanders }
        });
        Box::new(Self { pairs, sizes_rad: segment_sizes(rng, size_rms_m * scene.geometry.wavenumber()) })
    }
}

impl PlantEffect for QuadratureDrift {
    fn scale(&mut self, factor: f64) {
        self.sizes_rad = self.sizes_rad.map(|size| size * factor);
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        for ((signal, pair), size) in signals.iter_mut().zip(&self.pairs).zip(self.sizes_rad) {
            let flaw = |i: usize| size * pair.weights[i] * pair.wanders[i].at(at.time_s);
            let (sine_offset, cosine_offset, gain, angle) = (flaw(0), flaw(1), flaw(2), flaw(3));
            signal.sine = (1.0 + 0.5 * gain) * (signal.sine * angle.cos() + signal.cosine * angle.sin()) + sine_offset;
            signal.cosine = (1.0 - 0.5 * gain) * signal.cosine + cosine_offset;
        }
    }
}
