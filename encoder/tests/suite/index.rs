//! An index: turns begin at it, wherever the recording's count begins.

use crate::spun::{Spins, places_read, random};
use encoder::{Input, Question, learn};
use std::f64::consts::TAU;

const PERIODS: f64 = 20.0;
/// Place of the index behind a phase zero, and its length, periods.
const EDGE: f64 = 0.2;
const LENGTH: f64 = 0.5;

/// What is to be added at a place that is read, periods, from the phase zero at the index.
fn of_turn(place: f64) -> f64 {
    let angle = TAU * place / PERIODS;
    0.004 * (angle + 0.5).sin() + 0.002 * (3.0 * angle).cos()
}

/// Both ways, nine turns each, and some more; the count begins at `start` periods behind the phase zero at the index.
fn recording(start: f64, seed: u64) -> Input {
    let spins = Spins {
        speeds: vec![30.0, -30.0, 20.0],
        seconds: 6.0,
        decay: 0.0,
        // A heavy wheel: over a turn of 0.7 s it is pushed off by a twentieth of the error.
        jitter: 0.001,
        ..Spins::by_hand()
    };
    let mut random = random(seed);
    let (t_s, mut places) = spins.places(&mut random);
    places.iter_mut().for_each(|place| *place += start);
    let mut input = places_read(&t_s, &places, of_turn, 2.0e-5, &mut random);
    let level = |place: &f64| f64::from((place - EDGE).rem_euclid(PERIODS) < LENGTH);
    input.index = places.iter().map(level).collect();
    input.place.iter_mut().for_each(|place| *place -= start);
    input
}

#[test]
fn turns_are_counted_from_the_index_wherever_the_count_begins() {
    for (start, seed) in [(3.0, 1), (-46.0, 2)] {
        let answer = learn(&recording(start, seed), &Question::default()).unwrap();
        let turn = answer.turn.as_ref().expect("orders of the turn");
        let index = turn.index.as_ref().expect("an index");
        assert_eq!(f64::from(turn.periods), PERIODS);
        assert_eq!((index.zero_periods as f64 + start).rem_euclid(PERIODS), 0.0);
        // Samples are up to 30 periods/s over 2,000 a second apart, and the error is up to 0.006.
        assert!(
            (index.after_periods - EDGE).abs() < 0.015 + 0.006,
            "{index:?}"
        );
        assert!(
            index.spread_periods < 2.0 * (0.015 + 0.006) && index.passes > 20,
            "{index:?}"
        );
        let squares = |of: &dyn Fn(f64) -> f64| -> f64 {
            (0..200).map(|k| of(f64::from(k) / 10.0).powi(2)).sum()
        };
        let left = squares(&|place| turn.at(place) - of_turn(place)) / squares(&of_turn);
        println!("{start}: {:.3} of the error is left", left.sqrt());
        // A turn that begins a period off leaves 2 sin(pi / 20), 31 %, of its first order.
        assert!(left.sqrt() < 0.1, "{left}");
        let by_count = |place: f64| answer.of_turn(place - start) - turn.at(place);
        assert!(squares(&by_count).sqrt() < 1e-9);
    }
}

#[test]
fn an_index_that_comes_at_another_period_is_refused() {
    let mut input = recording(3.0, 1);
    let later = input.place.len() / 2;
    input.place[later..]
        .iter_mut()
        .for_each(|place| *place += 1.0);
    let refusal = learn(&input, &Question::default()).unwrap_err().to_string();
    assert!(refusal.contains("in each turn of 20 periods"), "{refusal}");

    let question = Question {
        periods_per_turn: Some(19),
    };
    let refusal = learn(&recording(3.0, 1), &question)
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("each turn of 19 periods: another --periods-per-turn"),
        "{refusal}"
    );

    let mut input = recording(3.0, 1);
    input.index.fill(1.0);
    let refusal = learn(&input, &Question::default()).unwrap_err().to_string();
    assert!(refusal.contains("without a rising edge"), "{refusal}");
}
