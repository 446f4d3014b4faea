//! Nothing that the reader takes ends in an error of the program: a sample of what `cargo xtask robustness` tries by the thousand.

use robustness::{draw, through::through};
use std::collections::BTreeSet;

/// Recordings: some tens of seconds of processor time.
const COUNT: u64 = 120;
/// Where their numbers begin: not where the nightly command's do.
const FIRST: u64 = 5_000_000;

#[test]
fn no_random_recording_ends_in_an_error_of_the_program() {
    let mut answered = BTreeSet::new();
    for number in FIRST..FIRST + COUNT {
        let drawn = draw::recording(number);
        let outcome = through(&drawn, &draw::recording(number + COUNT));
        assert_eq!(outcome.crashes, [], "number {number}");
        answered.extend(outcome.answered);
    }
    // A command that refuses every recording is not tried by them. `map` refuses all of these, being so small; it is tried as far
    // as the refusal.
    let tried = BTreeSet::from(["check", "diagnose", "replay"]);
    assert!(answered.is_superset(&tried), "{answered:?}");
}
