//! `outlier_bursts`: short disturbances far outside the noise.
//!
//! Switching of the motors' amplifiers couples into the sense coils for some milliseconds, now and then.

// --- plant side: disturbance at the converter ---

use crate::plant::{Channels, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, fork, index, log_uniform, normal, uniform};

/// Spread of a burst's strength: standard deviation of its logarithm.
const SPREAD: f64 = 0.5;

/// Plant side. Size: rms over all samples, quiet ones included, pooled over the segments (in expectation).
pub struct OutlierBursts {
    rng: ChaCha8Rng,
    hit: [bool; SEGMENTS],
    amplitude_counts: f64,
    rate_hz: f64,
    length_s: f64,
    ends_s: f64,
    strength: f64,
    last_s: f64,
}

impl OutlierBursts {
    /// 0.3 % to 2 % of the time, 1 to 20 ms long, on one segment or on all.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let share = log_uniform(rng, 0.003, 0.02);
        let length_s = log_uniform(rng, 1.0e-3, 20.0e-3);
        let one = index(rng, SEGMENTS);
        let all = uniform(rng, 0.0, 1.0) < 0.5;
        let hit: [bool; SEGMENTS] = core::array::from_fn(|s| all || s == one);
        let hits = hit.iter().filter(|h| **h).count() as f64;
        // Mean square of a log-normal strength of median 1 is exp(2 spread^2).
        let strength = (2.0 * SPREAD * SPREAD).exp().sqrt();
        let in_burst_m = size_rms_m * (SEGMENTS as f64 / hits / share).sqrt() / strength;
        Box::new(Self {
            rng: fork(rng),
            hit,
            amplitude_counts: in_burst_m * scene.counts_per_m(),
            rate_hz: share / length_s,
            length_s,
            ends_s: f64::NEG_INFINITY,
            strength: 0.0,
            last_s: f64::NEG_INFINITY,
        })
    }

    /// Starts a burst if one began since the last sample and has not ended yet.
    fn advance(&mut self, now_s: f64) {
        let window_s = (now_s - self.last_s).min(self.length_s);
        self.last_s = now_s;
        if now_s > self.ends_s && uniform(&mut self.rng, 0.0, 1.0) < 1.0 - (-self.rate_hz * window_s).exp() {
            self.ends_s = now_s + self.length_s - uniform(&mut self.rng, 0.0, window_s);
            self.strength = (SPREAD * normal(&mut self.rng)).exp();
        }
    }
}

impl PlantEffect for OutlierBursts {
    fn scale(&mut self, factor: f64) {
        self.amplitude_counts *= factor;
    }

    fn analog(&mut self, at: &Instant, channels: &mut Channels) {
        self.advance(at.time_s);
        if at.time_s > self.ends_s {
            return;
        }
        let counts = self.amplitude_counts * self.strength;
        for (pair, _) in channels.quadrature.iter_mut().zip(self.hit).filter(|(_, hit)| *hit) {
            pair.iter_mut().for_each(|value| *value += counts * normal(&mut self.rng));
        }
    }
}

// --- what is known of it ---

use crate::effect::{Card, Transfer, Confusable, Effect, Detection, Quantity};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "outlier_bursts",
    summary: "short disturbances far outside the noise",
    sizes: "far outside the noise: samples that no draw of it reaches",
    detection: Detection::AsBursts,
    follows: Quantity::Nothing,
    transfer: Transfer::Anew,
    carries_over: "nothing: each recording has its own bursts, which are left out",
    confusable: &[
        Confusable { with: "excess_noise", parted_by: "many weak bursts are noise: a longer recording at rest shows whether they come alone" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        OutlierBursts::draw(scene, rng, size_rms_m)
    }
}
