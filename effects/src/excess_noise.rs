//! `excess_noise`: white noise above the stated level.

// --- plant side: noise at the converter ---

use crate::plant::{Channels, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, fork, normal, uniform};
use crate::shape::segment_sizes;

/// Plant side. Size: rms of the segments' positions, pooled.
pub struct ExcessNoise {
    rng: ChaCha8Rng,
    quadrature_counts: [f64; SEGMENTS],
    electrode_share: f64,
}

impl ExcessNoise {
    /// Segments differ; the coordination sensor has it too in one case of three.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let geometry = &scene.geometry;
        // An electrode's noise s moves c by sqrt(2) s / sum * h * full scale.
        let share = size_rms_m / (geometry.height_m * geometry.tan_full_scale) / 2.0_f64.sqrt();
        Box::new(Self {
            quadrature_counts: segment_sizes(rng, size_rms_m * scene.counts_per_m()),
            electrode_share: if uniform(rng, 0.0, 3.0) < 1.0 { share } else { 0.0 },
            rng: fork(rng),
        })
    }
}

impl PlantEffect for ExcessNoise {
    fn scale(&mut self, factor: f64) {
        self.quadrature_counts = self.quadrature_counts.map(|counts| counts * factor);
        self.electrode_share *= factor;
    }

    fn analog(&mut self, _at: &Instant, channels: &mut Channels) {
        for (pair, counts) in channels.quadrature.iter_mut().zip(self.quadrature_counts) {
            pair.iter_mut().for_each(|value| *value += counts * normal(&mut self.rng));
        }
        let counts = self.electrode_share * channels.psd_sum_counts;
        channels.electrodes.iter_mut().for_each(|value| *value += counts * normal(&mut self.rng));
    }
}

// --- what is known of it ---

use crate::effect::{Card, Transfer, Confusable, Effect, Detection, Quantity, Recordings};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "excess_noise",
    summary: "white noise above the stated level",
    sizes: "a tenth above the stated level and more",
    recordings: Recordings::Still,
    detection: Detection::AsNoise,
    follows: Quantity::Nothing,
    transfer: Transfer::Anew,
    carries_over: "its level",
    confusable: &[
        Confusable { with: "outlier_bursts", parted_by: "many weak bursts are noise: a longer recording at rest shows whether they come alone" },
        Confusable { with: "beacon_vibration", parted_by: "a line that lies between two samples is noise: the full sample rate while standing still tells" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        ExcessNoise::draw(scene, rng, size_rms_m)
    }
}
