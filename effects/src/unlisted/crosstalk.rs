//! A segment's signals leak into the next one's amplifier.

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, Signal};
use crate::random::{ChaCha8Rng, normal};
use crate::shape::root_mean_square;

/// Size: rms of the displacement over independent phases of x and y at small angles, pooled over the segments.
pub struct Crosstalk {
    /// `[into][from]`: share of each channel.
    leak: [[f64; SEGMENTS]; SEGMENTS],
}

impl Crosstalk {
    /// Neighbours on the board leak more than the others.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let share = |into: usize, from: usize| match into.abs_diff(from) {
            0 => 0.0,
            1 => 1.0,
            _ => 0.25,
        };
        let leak: [[f64; SEGMENTS]; SEGMENTS] =
            core::array::from_fn(|into| core::array::from_fn(|from| share(into, from) * normal(rng)));
        // Leaks of shares k from the other axis' pair, whose phases are near equal, turn the phase by the sum of k times the
        // sine of the phases' difference; the own axis' other segment is in phase and turns it little.
        let power: [f64; SEGMENTS] = core::array::from_fn(|into| {
            let across = (0..SEGMENTS).filter(|from| (from + into) % 2 == 1);
            0.5_f64.sqrt() * across.map(|from| leak[into][from]).sum::<f64>()
        });
        let mut effect = Self { leak };
        effect.scale(size_rms_m * scene.geometry.wavenumber() / root_mean_square(&power));
        Box::new(effect)
    }
}

impl PlantEffect for Crosstalk {
    fn scale(&mut self, factor: f64) {
        self.leak.iter_mut().flatten().for_each(|k| *k *= factor);
    }

    fn signal(&mut self, _at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let clean = *signals;
        for (signal, row) in signals.iter_mut().zip(&self.leak) {
            for (k, from) in row.iter().zip(&clean) {
                signal.sine += k * from.sine;
                signal.cosine += k * from.cosine;
            }
        }
    }
}
