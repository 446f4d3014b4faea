//! Nothing that the reader takes ends in an error of the program: a sample of what `cargo xtask robustness` tries by the thousand.

use robustness::{draw, through::through};

/// Recordings: some tens of seconds of processor time.
const COUNT: u64 = 120;
/// Where their numbers begin: not where the nightly command's do.
const FIRST: u64 = 5_000_000;

#[test]
fn no_random_recording_ends_in_an_error_of_the_program() {
    let mut answers = 0;
    for number in FIRST..FIRST + COUNT {
        let drawn = draw::recording(number);
        let outcome = through(&drawn, &draw::recording(number + COUNT));
        assert_eq!(outcome.crashes, [], "number {number}");
        answers += outcome.answered.len();
    }
    // A generator whose recordings are all refused would test nothing: one answer in ten recordings shows that it is not so.
    assert!(answers as u64 > COUNT / 10, "{answers} answers");
}
