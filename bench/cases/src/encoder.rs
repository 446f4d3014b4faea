//! One pair by itself: its readings, and what is learned from them.

use crate::digest::Digest;
use crate::inputs::Random;
use courier_sensor::encoder::{
    Encoder, EncoderConfig, Harmonics, Learner, Reading, TURN_DRIFT, TurnLearner, TurnTable,
};
use courier_sensor::lsq::packed_len;
use courier_sensor::math::sincos_turns;
use courier_sensor::quadrature::PairCorrection;

/// Samples of one check: 60 periods, there and back.
pub const SAMPLES: u32 = 6_000;

/// Periods of a turn.
pub const TURN: u32 = 12;
/// Unknowns of twenty orders of the turn, and of as many as a ring of 25 pole pairs needs.
const UNKNOWNS: usize = TURN_DRIFT + 2 * 20;
const RING_UNKNOWNS: usize = TURN_DRIFT + 2 * 50;
/// What learns twenty orders of the turn.
pub type Turns = TurnLearner<UNKNOWNS, { packed_len(UNKNOWNS) }>;
/// What learns those of a ring of 25 pole pairs.
pub type RingTurns = TurnLearner<RING_UNKNOWNS, { packed_len(RING_UNKNOWNS) }>;
/// A table of either.
pub type Table = TurnTable<256>;

/// A pair with a correction and all orders, and its motion.
pub struct Turning {
    encoder: Encoder,
    random: Random,
    turns: f32,
    sample: u32,
}

impl Turning {
    /// From a seed; none if the constants were out of range.
    #[must_use]
    pub fn new(seed: u64) -> Option<Self> {
        let pair = PairCorrection {
            offset_counts: [120.0, -80.0],
            gain: 1.02,
            angle_rad: 0.03,
        };
        let mut harmonics = Harmonics::default();
        let mut random = Random::new(seed);
        harmonics
            .turns
            .as_flattened_mut()
            .fill_with(|| 1.0e-3 * random.signed());
        Some(Self {
            encoder: Encoder::new(EncoderConfig::new(&pair, &harmonics, 0.2, 0.25).ok()?),
            random,
            turns: 0.0,
            sample: 0,
        })
    }

    /// The next counts: turns there and back, noise of two counts.
    pub fn counts(&mut self) -> [i16; 2] {
        let forward = self.sample < SAMPLES / 2;
        let step = if forward { 0.01 } else { -0.01 };
        self.turns += step;
        self.turns -= (self.turns as i32) as f32;
        self.sample = (self.sample + 1) % SAMPLES;
        let (sine, cosine) = sincos_turns(self.turns);
        [sine, cosine].map(|x| (20_000.0 * x + 2.0 * self.random.signed()) as i16)
    }

    /// One sample.
    pub fn read(&mut self, counts: [i16; 2]) -> Reading {
        self.encoder.step(counts)
    }
}

/// Digest of all readings and of what they teach, into learners of the caller's (they are large).
pub fn digest(learner: &mut Learner, turns: &mut Turns) -> u64 {
    let mut digest = Digest::default();
    let Some(mut turning) = Turning::new(11) else {
        return 0;
    };
    for _ in 0..SAMPLES {
        let counts = turning.counts();
        let reading = turning.read(counts);
        digest.word(reading.periods as u32);
        digest.word(u32::from(reading.slipped));
        digest.floats(&[
            reading.phase.sine,
            reading.phase.cosine,
            reading.amplitude_counts,
            reading.unmodified_turns,
            reading.calibrated_turns,
        ]);
        learner.enter(&reading);
        turns.enter(&reading, 5);
    }
    if let Ok(learned) = turns.solve() {
        digest.word(learned.orders as u32);
        digest.floats(&learned.values);
        digest.floats(&learned.deviations);
        let table = Table::new(&learned);
        let reading = turning.read([9_000, -7_000]);
        digest.floats(&[learned.before, learned.after, table.at(&reading, 5)]);
    }
    if let Ok(learned) = learner.solve() {
        digest.word(learned.stretches);
        digest.floats(learned.harmonics.turns.as_flattened());
        digest.floats(learned.deviations.as_flattened());
    }
    if let Ok(round) = learner.circle.solve() {
        digest.floats(round.orders.as_flattened());
        digest.floats(&[round.amplitude_counts]);
    }
    digest.value()
}
