//! One encoder at an RP2350's own converter: sine at GPIO 26, cosine at GPIO 27. It is compiled, and not run (docs/encoder.md).
#![no_std]
#![no_main]

mod converter;

use self::converter::Converter;

use courier_signal::encoder::{
    Encoder, EncoderConfig, Harmonics, Learner, TURN_DRIFT, TurnLearner, TurnTable,
};
use courier_signal::lsq::packed_len;
use core::hint::black_box;
use courier_signal::quadrature::PairCorrection;
use panic_halt as _;

/// Readings between two looks at what was learned: the converter takes 2 µs for each channel and `step` some 5, so about a second.
const READINGS: u32 = 100_000;
/// Largest step from the foretold phase at which periods are counted, turns, and the newest step's share in the speed.
const SLIP_TURNS: f32 = 0.2;
const SPEED_FILTER: f32 = 0.25;

/// A ring of 25 pole pairs, and two orders of the turn for each: 47 KiB. It has no index: a turn begins where the shaft stood at the start.
const PERIODS: u32 = 25;
const UNKNOWNS: usize = TURN_DRIFT + 4 * PERIODS as usize;
const TURN_START: i32 = 0;

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut converter = Converter::start([0, 1]);
    let mut pair = PairCorrection::default();
    let none = Harmonics::default();
    let Ok(config) = EncoderConfig::new(&pair, &none, SLIP_TURNS, SPEED_FILTER) else {
        loop {}
    };
    let mut encoder = Encoder::new(config);
    let mut learner = Learner::new();
    let mut turns = TurnLearner::<UNKNOWNS, { packed_len(UNKNOWNS) }>::new(PERIODS);
    let mut table: Option<TurnTable<800>> = None;
    let mut is_straight = false;
    loop {
        for _ in 0..READINGS {
            // A conversion that failed is no reading.
            let Some(read) = converter.read() else {
                continue;
            };
            // Twelve bits about half the supply.
            let counts = read.map(|count| count as i16 - 2048);
            let reading = encoder.step(counts);
            let of_turn = table
                .as_ref()
                .map_or(0.0, |table| table.at(&reading, TURN_START));
            // The place, for whoever wants it.
            black_box((reading.periods, reading.calibrated_turns + of_turn));
            if is_straight {
                turns.enter(&reading, TURN_START);
            } else {
                learner.enter(&reading);
            }
        }
        // While the shaft is spun: the circle first, the angle's orders once that is round, and then the orders of the turn.
        if is_straight {
            if let Ok(learned) = turns.solve() {
                table = Some(TurnTable::new(&learned));
            }
            continue;
        }
        let (round, learned) = (learner.circle.solve(), learner.solve());
        let mut harmonics = none;
        if let Ok(round) = round {
            let corrected = round.correction(&pair);
            let moved = [0, 1].map(|k| corrected.offset_counts[k] - pair.offset_counts[k]);
            if let (true, Ok(learned)) = (moved.iter().all(|moved| moved.abs() < 1.0), learned) {
                harmonics = learned.harmonics;
                is_straight = true;
            }
            pair = corrected;
        }
        if let Ok(config) = EncoderConfig::new(&pair, &harmonics, SLIP_TURNS, SPEED_FILTER) {
            encoder.configure(config);
        }
        learner = Learner::new();
    }
}
