//! `cycle_slip`: a tooth count is off by whole teeth from some moment on.

// --- plant side: the tooth counters' error ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, index, sign, uniform};

/// Plant side. Its size is whole pitches, whatever was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleSlip {
    /// `(time, segment, teeth)` of each slip.
    pub slips: Vec<(f64, usize, i32)>,
}

impl CycleSlip {
    /// One slip, seldom two on different segments, of one tooth, seldom two, within the middle of the recording.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, _size_rms_m: f64) -> Box<dyn PlantEffect> {
        let count = if uniform(rng, 0.0, 1.0) < 0.8 { 1 } else { 2 };
        let first = index(rng, SEGMENTS);
        let slips = (0..count).map(|i| {
            let teeth = if uniform(rng, 0.0, 1.0) < 0.85 { 1.0 } else { 2.0 };
            let time_s = scene.duration_s * uniform(rng, 0.15, 0.85);
            (time_s, (first + i) % SEGMENTS, (teeth * sign(rng)) as i32)
        });
        Box::new(Self { slips: slips.collect() })
    }
}

impl PlantEffect for CycleSlip {
    fn scale(&mut self, _factor: f64) {}

    fn teeth(&mut self, at: &Instant) -> [i32; SEGMENTS] {
        let mut off = [0; SEGMENTS];
        for &(_, segment, teeth) in self.slips.iter().filter(|slip| slip.0 <= at.time_s) {
            off[segment] += teeth;
        }
        off
    }
}

// --- what is known of it ---

use crate::effect::{Card, Transfer, Effect, Detection, Quantity};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "cycle_slip",
    summary: "a tooth count is off by whole teeth from some moment on",
    sizes: "whole pitches",
    detection: Detection::AsSlips,
    follows: Quantity::Nothing,
    transfer: Transfer::Anew,
    carries_over: "nothing: each recording has its own slips, which are repaired",
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        CycleSlip::draw(scene, rng, size_rms_m)
    }
}
