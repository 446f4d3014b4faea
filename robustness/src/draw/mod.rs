//! One random recording from one number.

mod chance;
mod columns;
mod courier;
mod cut;
mod runs;
mod stated;
mod under_beacon;

use chance::chance;
use cut::cut;
use effects::plant::SEGMENTS;
use effects::random::{ChaCha8Rng, SeedableRng, index};
use recording::Recording;
use std::path::Path;

/// Draws until one is valid: what is stated may forbid counts that were drawn.
const TRIES: u64 = 20;

/// The recording of a number: the same one on every machine. It is one that the reader takes.
///
/// # Panics
/// None of many draws was valid: a fault of this generator, whose number the text holds.
#[must_use]
pub fn recording(number: u64) -> Recording {
    valid(number, one)
}

/// One that a tooth map can mostly be made of.
///
/// # Panics
/// As [`recording()`].
#[must_use]
pub fn under_beacon(number: u64) -> Recording {
    valid(number, under_beacon::drawn)
}

fn valid(number: u64, draw: fn(&mut ChaCha8Rng) -> Recording) -> Recording {
    for stream in 0..TRIES {
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        rng.set_stream(stream);
        let drawn = draw(&mut rng);
        if drawn.check(Path::new("samples.csv")).is_ok() {
            return drawn;
        }
    }
    panic!("number {number}: {TRIES} draws, wanted one that the reader takes");
}

/// One recording in so many is one that a tooth map can be made of: it takes as long as fifty other recordings.
const ONE_UNDER_A_BEACON_OF: usize = 100;
/// Share of the others with one segment and a reference: a fit of one channel takes a tenth of the time of one of six.
const ONE_SEGMENT: f64 = 0.8;
/// Share that is left as it was recorded, and long enough to be diagnosed: of what is cut and changed most is refused.
const WHOLE: f64 = 0.25;

fn one(rng: &mut ChaCha8Rng) -> Recording {
    if index(rng, ONE_UNDER_A_BEACON_OF) == 0 {
        return under_beacon::drawn(rng);
    }
    let (is_whole, rows) = if chance(rng, WHOLE) {
        (true, runs::ENOUGH_ROWS)
    } else {
        (false, runs::ROWS)
    };
    let (mut courier, plan) = runs::courier_and_plan(rows, rng);
    let has_one_segment = chance(rng, ONE_SEGMENT);
    let with_reference = has_one_segment || chance(rng, 0.4);
    let mut drawn = hal_sim::record::record(&mut courier, &plan, with_reference);
    if has_one_segment {
        drawn = columns::of_one_segment(&drawn, index(rng, SEGMENTS));
    }
    if is_whole {
        return drawn;
    }
    drawn = columns::changed(&cut(&drawn, rng), rng);
    stated::restate(&mut drawn.meta, rng);
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::Column;

    /// What these draws hold between them: every kind of column is there in some and not in others.
    #[test]
    fn draws_differ_in_everything_that_a_recording_may_hold() {
        let drawn: Vec<Recording> = (0..150).map(recording).collect();
        let some = |what: &dyn Fn(&Recording) -> bool| {
            let count = drawn.iter().filter(|r| what(r)).count();
            assert!((1..drawn.len()).contains(&count), "{count}");
        };
        for column in [
            Column::Sine(0),
            Column::Sine(3),
            Column::Position(1),
            Column::Teeth(2),
            Column::Electrode(0),
            Column::Temperature,
            Column::Commanded(0),
            Column::Reference(0),
            Column::Reference(2),
        ] {
            some(&|r| r.samples.has(column));
        }
        some(&|r| r.samples.run_names().len() > 1);
        some(&|r| r.samples.len() < 300);
        some(&|r| r.meta.geometry.pitch_m == effects::plant::Geometry::PAPER.pitch_m);
    }

    #[test]
    fn a_number_gives_the_same_recording_again() {
        assert!(recording(7) == recording(7));
        assert!(recording(7) != recording(8));
    }
}
