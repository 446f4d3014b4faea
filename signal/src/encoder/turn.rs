//! On the device: what repeats with the turn and not with the period, single poles and eccentricity.

use super::pair::Reading;
use super::turn_half::{Half, TURN_DRIFT};
use crate::math::sqrt;
use crate::model::Unit;
use core::ops::Range;

/// Turns of a stretch. Derived from what is repeated: with fewer than two nothing is.
pub const TURNS: u32 = 2;
/// Rows to a wave of the highest order. Derived from the sampling theorem, with a factor of four for noise.
const ROWS_A_WAVE: f32 = 8.0;
/// A way back of so much, periods, ends a stretch. A prior: noise and errors go back by less.
const BACK: f32 = 0.25;
/// A stretch ends where its mean speed has become so many times that of its first period, or so many times less. Derived from a shaft that coasts
/// with friction as its speed: its mean speed is half where its speed is a fifth, and over such a stretch a quintic leaves 6e-6 of the way.
const FASTER: f32 = 2.0;
/// As for a period's stretches, a stretch that takes more samples ends. A bound on the work: 52 s at 20 kHz.
const MOST_SAMPLES: u32 = 1 << 20;
/// Samples to the time in a row. Derived from the longest stretch: its fifth power is 2^50 in this unit, whose square an f32 holds.
const TIME_UNIT: f32 = 1.0 / 1024.0;

/// Learns orders of the turn from readings whose circle and whose orders of the period are applied already. `UNKNOWNS` is [`TURN_DRIFT`]
/// and two for each order of the turn, `PACKED` is `packed_len(UNKNOWNS)`; memory is eight bytes for each of `PACKED`: 50 orders
/// (twice a ring's 25 poles) take 47 KiB.
#[derive(Clone, Debug)]
pub struct TurnLearner<const UNKNOWNS: usize, const PACKED: usize> {
    /// Two halves of the stretches: what one says is tried on the other.
    halves: [Half<UNKNOWNS, PACKED>; 2],
    /// The one that the stretch goes to.
    current: usize,
    periods: u32,
    stretch: Option<Begun>,
    stretches: u32,
}

/// A stretch that has begun.
#[derive(Clone, Copy, Debug)]
struct Begun {
    periods: i32,
    turns: f32,
    samples: u32,
    /// Samples of the first period; zero within it.
    first: u32,
    /// Way since the beginning, periods: of the last row, and the farthest.
    entered: f32,
    farthest: f32,
}

impl Begun {
    fn at(reading: &Reading) -> Self {
        Self {
            periods: reading.periods,
            turns: reading.calibrated_turns,
            samples: 0,
            first: 0,
            entered: 0.0,
            farthest: 0.0,
        }
    }

    /// Counts a reading; its way since the beginning, periods.
    fn pass(&mut self, reading: &Reading) -> f32 {
        self.samples += 1;
        let moved = reading.periods.wrapping_sub(self.periods) as f32
            + (reading.calibrated_turns - self.turns);
        if moved.abs() > self.farthest.abs() {
            self.farthest = moved;
        }
        if self.first == 0 && moved.abs() >= 1.0 {
            self.first = self.samples;
        }
        moved
    }

    /// Whether the motion has turned back, stands, or is another than it was.
    fn is_over(&self, moved: f32) -> bool {
        let at_first = self.first as f32 * moved.abs();
        let samples = self.samples as f32;
        let is_other =
            self.first > 0 && !(at_first / FASTER..=at_first * FASTER).contains(&samples);
        is_other || self.samples > MOST_SAMPLES || (self.farthest - moved).abs() > BACK
    }
}

/// Orders of the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedTurn<const UNKNOWNS: usize> {
    /// Periods of a turn.
    pub periods: u32,
    /// `a_m` and `b_m` of orders 1 and up, periods of the signal: `a_m sin(m angle) + b_m cos(m angle)` is to be added to the place. The
    /// first `2 * orders` count.
    pub values: [f32; UNKNOWNS],
    /// Their standard deviations, by how far the two halves of the stretches are from each other.
    pub deviations: [f32; UNKNOWNS],
    /// How many orders foretell best what they were not fitted to.
    pub orders: usize,
    /// What one half of the stretches shows, and what of it is left by orders fitted to the other, rms periods.
    pub before: f32,
    #[allow(missing_docs)]
    pub after: f32,
    /// Stretches of two turns that it rests on; shorter ones count beside them.
    pub stretches: u32,
}

/// Why no orders of the turn are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TurnError {
    /// Fewer than two stretches, of which one is of two turns.
    TooFewTurns,
    /// No number of orders foretells what it was not fitted to: there is no more than chance.
    Chance,
}

impl core::fmt::Display for TurnError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TooFewTurns => "more than two turns without a stop are wanted",
            Self::Chance => "what differs from period to period is no more than chance",
        })
    }
}

impl core::error::Error for TurnError {}

impl<const UNKNOWNS: usize, const PACKED: usize> TurnLearner<UNKNOWNS, PACKED> {
    /// Most orders.
    const ORDERS: usize = (UNKNOWNS - TURN_DRIFT) / 2;

    /// Without a reading, for turns of `periods` (1 and up) of the signal.
    #[must_use]
    pub const fn new(periods: u32) -> Self {
        const { assert!(UNKNOWNS >= TURN_DRIFT + 2) };
        let periods = if periods == 0 { 1 } else { periods };
        Self {
            halves: [const { Half::new() }; 2],
            current: 0,
            periods,
            stretch: None,
            stretches: 0,
        }
    }

    /// Takes a reading at regular instants, moving or not. `turn_start` is the whole place at which a turn begins, as
    /// [`Reading::nearest_zero`] gives it at an index; without one any, and the same always. Not in the interrupt: at eight places of the
    /// highest order's wave it enters a row, which takes some 27,000 instructions for 50 orders; the first row of each half takes a hundred times that.
    pub fn enter(&mut self, reading: &Reading, turn_start: i32) {
        let Some(begun) = self.stretch.as_mut().filter(|_| !reading.slipped) else {
            self.begin(reading);
            return;
        };
        let moved = begun.pass(reading);
        if begun.is_over(moved) {
            self.begin(reading);
            return;
        }
        let turn = self.periods as f32;
        // Onwards only: where the shaft was pushed back, its motion has a corner.
        let onwards = if begun.farthest < 0.0 { -1.0 } else { 1.0 };
        let further = onwards * (moved - begun.entered);
        if further < turn / (ROWS_A_WAVE * Self::ORDERS as f32) {
            return;
        }
        begun.entered = moved;
        let time = begun.samples as f32 * TIME_UNIT;
        let angle = Unit::from_turns(reading.of_turn(self.periods, turn_start));
        let half = &mut self.halves[self.current];
        half.enter(time, moved, angle);
        half.way += further;
        if moved.abs() >= TURNS as f32 * turn {
            self.stretches += 1;
            self.begin(reading);
        }
    }

    /// The next stretch goes to the half that has gone less far.
    fn begin(&mut self, reading: &Reading) {
        self.halves[self.current].factor.release(TURN_DRIFT);
        self.current = usize::from(self.halves[0].way > self.halves[1].way);
        self.stretch = Some(Begun::at(reading));
    }

    /// What repeats with the turn, in as many orders as foretell best. What was learned stays, in one half; the other is then filled anew.
    /// Background only: some 10 `orders`³ operations.
    ///
    /// # Errors
    /// [`TurnError`].
    pub fn solve(&mut self) -> Result<LearnedTurn<UNKNOWNS>, TurnError> {
        let way = self.halves[0].way.min(self.halves[1].way);
        // A turn, but for a period at its ends.
        if self.stretches == 0 || way + 1.0 < self.periods as f32 {
            return Err(TurnError::TooFewTurns);
        }
        let before = self.foretold(0);
        let (mut orders, mut after) = (0, before);
        for number in 1..=Self::ORDERS {
            let left = self.foretold(number);
            if left < after {
                (orders, after) = (number, left);
            }
        }
        if orders == 0 {
            return Err(TurnError::Chance);
        }
        let block = Self::block(orders);
        let scatter = self.scatter(&block);
        let [first, second] = &mut self.halves;
        first.take(second);
        // Both have one now.
        self.current = 1;
        self.stretch = None;
        let solution = first.factor.block_solution(block.clone());
        let mut learned = LearnedTurn {
            periods: self.periods,
            values: [0.0; UNKNOWNS],
            deviations: [0.0; UNKNOWNS],
            orders,
            before,
            after,
            stretches: self.stretches,
        };
        for (slot, unknown) in block.clone().enumerate() {
            let variance = first.factor.block_variance(block.clone(), unknown);
            learned.values[slot] = solution[unknown];
            learned.deviations[slot] = sqrt(scatter * variance);
        }
        Ok(learned)
    }

    /// The unknowns of orders 1 to `orders`.
    fn block(orders: usize) -> Range<usize> {
        TURN_DRIFT..TURN_DRIFT + 2 * orders
    }

    /// Root of the mean square that either half's orders leave of the other, periods.
    fn foretold(&self, orders: usize) -> f32 {
        let [first, second] = &self.halves;
        let left = |of: &Half<UNKNOWNS, PACKED>, by: &Half<UNKNOWNS, PACKED>| {
            let values = by.factor.block_solution(Self::block(orders));
            of.factor.square_left(TURN_DRIFT, &values)
        };
        let rows = first.rows as f32 + second.rows as f32;
        sqrt((left(first, second) + left(second, first)) / rows)
    }

    /// Variance of a row, by the squares of the halves' differences over what they are for rows of unit variance.
    fn scatter(&self, block: &Range<usize>) -> f32 {
        let of = |half: usize| &self.halves[half].factor;
        let [first, second] = [0, 1].map(|half| of(half).block_solution(block.clone()));
        let square = |unknown: usize| {
            let variances = [0, 1].map(|half| of(half).block_variance(block.clone(), unknown));
            let difference = first[unknown] - second[unknown];
            difference * difference / (variances[0] + variances[1])
        };
        block.clone().map(square).sum::<f32>() / block.len() as f32
    }
}

impl<const UNKNOWNS: usize> LearnedTurn<UNKNOWNS> {
    /// What is to be added at an angle of the turn, periods of the signal.
    #[must_use]
    pub fn at(&self, angle: Unit) -> f32 {
        let mut multiple = Unit::ZERO;
        let mut sum = 0.0;
        for [sine, cosine] in self.values.as_chunks::<2>().0.iter().take(self.orders) {
            multiple = multiple.plus(angle);
            sum += sine * multiple.sine + cosine * multiple.cosine;
        }
        sum
    }
}

#[cfg(test)]
mod tests;
