//! On the device: what repeats with the turn and not with the period, single poles and eccentricity.

use super::pair::Reading;
use crate::lsq::Triangle;
use crate::math::sqrt;
use crate::model::Unit;
use core::ops::Range;

/// Unknowns of the motion in each stretch: a quintic of time. A prior: a shaft that is spun by hand and coasts, or is driven, keeps to it
/// over two turns.
pub const TURN_DRIFT: usize = 6;
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
/// Weight of what is held of every order before any row: that it is zero, as a row of three times the noise says it. A prior: it decides only
/// where a motion's polynomial can do the same, and makes nothing up there; an order that a hundred rows tell it makes less by a thousandth.
const PRIOR: f32 = 0.3;
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

/// Rows of `place = quintic of time - error`: the motion's unknowns come first, so that what is below them is what all stretches say of the
/// error, whatever the motion was in each.
#[derive(Clone, Debug)]
struct Half<const UNKNOWNS: usize, const PACKED: usize> {
    factor: Triangle<UNKNOWNS, PACKED>,
    /// Without those of [`PRIOR`].
    rows: u32,
    /// Way of all stretches, periods.
    way: f32,
}

impl<const UNKNOWNS: usize, const PACKED: usize> Half<UNKNOWNS, PACKED> {
    const fn new() -> Self {
        Self {
            factor: Triangle::new(UNKNOWNS),
            rows: 0,
            way: 0.0,
        }
    }

    /// Empty but for what is held of every order before a row speaks of it.
    fn begin(&mut self) {
        self.factor.reset(UNKNOWNS);
        self.rows = 0;
        self.way = 0.0;
        for unknown in TURN_DRIFT..UNKNOWNS {
            let mut row = [0.0; UNKNOWNS];
            row[unknown] = PRIOR;
            // Refused is only what is not finite.
            let _ = self.factor.enter(&row, 0.0);
        }
    }

    fn enter(&mut self, time: f32, place: f32, angle: Unit) {
        if self.rows == 0 {
            self.begin();
        }
        let mut row = [0.0; UNKNOWNS];
        let (drift, orders) = row.split_at_mut(TURN_DRIFT);
        let mut power = 1.0;
        for slot in drift {
            *slot = power;
            power *= time;
        }
        let mut multiple = Unit::ZERO;
        for pair in orders.as_chunks_mut::<2>().0 {
            multiple = multiple.plus(angle);
            *pair = [-multiple.sine, -multiple.cosine];
        }
        if self.factor.enter(&row, place).is_ok() {
            self.rows = self.rows.saturating_add(1);
        }
    }

    /// Takes over what another says of the error, and leaves that empty.
    fn take(&mut self, other: &mut Self) {
        self.factor.release(TURN_DRIFT);
        for index in TURN_DRIFT..UNKNOWNS {
            let mut row = [0.0; UNKNOWNS];
            for (column, slot) in row.iter_mut().enumerate().skip(index) {
                *slot = other.factor.entry(index, column);
            }
            let _ = self.factor.enter(&row, other.factor.right_hand_side(index));
        }
        self.rows = self.rows.saturating_add(other.rows);
        self.way += other.way;
        // Its next row begins it anew.
        (other.rows, other.way) = (0, 0.0);
    }
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
mod tests {
    extern crate std;
    use super::*;
    use crate::encoder::TurnTable;
    use crate::lsq::packed_len;
    use core::f64::consts::TAU;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const PERIODS: u32 = 12;
    const UNKNOWNS: usize = TURN_DRIFT + 2 * 24;
    /// Orders of the turn that the shaft has, periods.
    const TRUE: [(usize, [f64; 2]); 4] = [
        (1, [0.01, -0.004]),
        (2, [0.0, 0.003]),
        (11, [0.002, 0.0]),
        (13, [-0.001, 0.002]),
    ];
    type Turns = TurnLearner<UNKNOWNS, { packed_len(UNKNOWNS) }>;

    /// What is added to the place to make it true.
    fn error(place: f64, size: f64) -> f64 {
        let angle = TAU * place / f64::from(PERIODS);
        let of = |(order, [a, b]): &(usize, [f64; 2])| {
            let (sine, cosine) = (*order as f64 * angle).sin_cos();
            a * sine + b * cosine
        };
        size * TRUE.iter().map(of).sum::<f64>()
    }

    fn reading(place: f64) -> Reading {
        let whole = place.round();
        let turns = (place - whole) as f32;
        Reading {
            phase: Unit::from_turns(turns),
            amplitude_counts: 20_000.0,
            periods: whole as i32,
            unmodified_turns: turns,
            calibrated_turns: turns,
            slipped: false,
        }
    }

    /// Pushed ten times, both ways in turn, and coasting with friction that grows with the speed: six turns, then two, and so on to rest.
    fn pushed(seed: u64, size: f64, noise: f64, mut each: impl FnMut(&Reading, f64)) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, noise).unwrap();
        let mut from = 0.0;
        for push in 0..10 {
            let way = if push % 2 == 0 { 90.0 } else { -80.0 };
            for n in 0..12_000 {
                let gone = way * (1.0 - (-f64::from(n) / 3_000.0).exp());
                let place = from + gone;
                // What is added belongs to the place as it is read.
                let read = (0..6).fold(place, |read, _| place - error(read, size));
                each(&reading(read + noise.sample(&mut random)), place);
            }
            from += way * (1.0 - (-4.0_f64).exp());
        }
    }

    /// Errors over stated deviations over 20 seeds of 48 numbers: their mean square is one within the noise of each scatter, which rests on 48
    /// differences (20 % a seed, 5 % in all), and within what a quintic lacks of a coasting shaft.
    #[test]
    fn deviations_are_those_of_repeated_motions() {
        let (mut squares, mut count) = (0.0, 0);
        for seed in 0..20 {
            let mut learner = Turns::new(PERIODS);
            pushed(seed, 1.0, 2.0e-4, |reading, _| learner.enter(reading, 0));
            let learned = learner.solve().unwrap();
            for order in 1..=learned.orders {
                let wanted = TRUE.iter().find(|(n, _)| *n == order);
                let wanted = wanted.map_or([0.0; 2], |(_, wanted)| *wanted);
                for part in 0..2 {
                    let slot = 2 * (order - 1) + part;
                    let error = f64::from(learned.values[slot]) - wanted[part];
                    squares += (error / f64::from(learned.deviations[slot])).powi(2);
                    count += 1;
                }
            }
        }
        let mean = squares / f64::from(count);
        std::println!("{mean:.3}");
        assert!((0.8..1.25).contains(&mean), "{mean}");
    }

    /// Without any, nothing is told as a rule, and else what is told is chance: it foretells no thousandth, and lies within what is stated.
    #[test]
    fn a_shaft_without_such_errors_has_none() {
        let mut none = 0;
        for seed in 0..10 {
            let mut learner = Turns::new(PERIODS);
            pushed(seed, 0.0, 2.0e-4, |reading, _| learner.enter(reading, 0));
            match learner.solve() {
                Err(TurnError::Chance) => none += 1,
                Err(error) => panic!("{error}"),
                Ok(learned) => {
                    assert!(learned.after > 0.999 * learned.before, "{learned:?}");
                    let pairs = learned.values.iter().zip(&learned.deviations);
                    for (value, deviation) in pairs.take(2 * learned.orders) {
                        assert!(value.abs() < 5.0 * deviation, "{learned:?}");
                    }
                }
            }
        }
        assert!(none > 5, "{none}");
    }

    /// Wherever the count begins: what the table adds is what lacks, but for the lines between its entries (8 % of the highest order that the
    /// shaft has, 13 of 24) and what chance leaves of an order.
    #[test]
    fn the_table_straightens_the_shaft_from_any_beginning() {
        for start in [0, 5, -31] {
            let mut learner = Turns::new(PERIODS);
            pushed(1, 1.0, 2.0e-4, |reading, _| learner.enter(reading, start));
            let table = TurnTable::<192>::new(&learner.solve().unwrap());
            let mut worst = 0.0_f64;
            pushed(2, 1.0, 0.0, |reading, place| {
                let read = f64::from(reading.periods) + f64::from(reading.calibrated_turns);
                worst = worst.max((read + f64::from(table.at(reading, start)) - place).abs());
            });
            let wave = 0.003 * (TAU * 13.0 / 192.0).powi(2) / 8.0;
            assert!(worst < wave + 10.0 * 6.0e-6, "{start}: {worst}");
        }
    }

    #[test]
    fn an_index_gives_the_whole_place_next_to_it() {
        for (place, zero) in [(7.4, 7), (7.6, 8), (-0.4, 0), (-0.6, -1)] {
            let mut read = reading(place);
            assert_eq!(read.nearest_zero(), zero);
            // The same place where harmonics lead over half a period.
            read.periods += 1;
            read.calibrated_turns -= 1.0;
            assert_eq!(read.nearest_zero(), zero);
        }
        let part = reading(-0.25).of_turn(12, -31);
        assert!((part - (30.75 - 24.0) / 12.0).abs() < 1.0e-6, "{part}");
    }

    /// Of one turn, of standing still and of swinging to and fro within a turn nothing is told.
    #[test]
    fn less_than_two_turns_tell_nothing() {
        let swings: [fn(f64) -> f64; 3] = [
            |n| 13.0 * n / 10_000.0,
            |_| 3.25,
            |n| 3.0 * (n / 500.0).sin(),
        ];
        for place in swings {
            let mut learner = Turns::new(PERIODS);
            for n in 0..10_000 {
                learner.enter(&reading(place(f64::from(n))), 0);
            }
            assert_eq!(learner.solve(), Err(TurnError::TooFewTurns));
        }
    }

    /// What was told is kept, and told better with more.
    #[test]
    fn learning_goes_on_after_an_answer() {
        let mut learner = Turns::new(PERIODS);
        pushed(5, 1.0, 2.0e-4, |reading, _| learner.enter(reading, 0));
        let once = learner.solve().unwrap();
        assert_eq!(learner.solve(), Err(TurnError::TooFewTurns));
        pushed(6, 1.0, 2.0e-4, |reading, _| learner.enter(reading, 0));
        let twice = learner.solve().unwrap();
        // Half the variance, as far as a scatter by 48 differences tells it each time.
        let ratio = twice.deviations[10] / once.deviations[10];
        assert!((0.5..0.95).contains(&ratio), "{ratio}");
    }
}
