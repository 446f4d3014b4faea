//! Nothing that the reader takes ends in an error of the program: a sample of what `cargo xtask robustness` tries by the thousand.

use robustness::{draw, through::through};
use std::collections::BTreeSet;

/// Recordings: some seconds of processor time.
const COUNT: u64 = 100;
/// Those of them that are one that a tooth map can be made of.
const UNDER_BEACON: [u64; 2] = [7, 11];
/// Where their numbers begin: not where the nightly command's do.
const FIRST: u64 = 5_000_000;

#[test]
fn no_random_recording_ends_in_an_error_of_the_program() {
    let mut answered = BTreeSet::new();
    let mut other = draw::recording(FIRST + COUNT);
    for number in FIRST..FIRST + COUNT {
        let drawn = if UNDER_BEACON.contains(&(number - FIRST)) {
            draw::under_beacon(number)
        } else {
            draw::recording(number)
        };
        let outcome = through(&drawn, &other);
        other = drawn;
        assert_eq!(outcome.crashes, [], "number {number}");
        answered.extend(outcome.answered);
    }
    // A command that refuses every recording is not tried by them.
    let tried = BTreeSet::from(["check", "diagnose", "map", "replay"]);
    assert!(answered.is_superset(&tried), "{answered:?}");
}
