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
