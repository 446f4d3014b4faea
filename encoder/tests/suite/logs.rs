//! Real logs of positions: a resolver with a known flaw, and an encoder that a motor's own log calibrates.

use crate::shared::shared;
use encoder::{Input, Question, learn};
use recording::Recording;

/// Each goes through one turn once a way: too little to tell its error's scatter, and the refusal says so.
#[test]
fn one_turn_there_and_back_is_refused_with_what_is_wanted() {
    for name in [
        "ess-rotary-normal",
        "ess-rotary-drive-divided",
        "moteus-calibration-log",
    ] {
        let Some(folder) = shared(name) else { return };
        let recording = Recording::read(folder).unwrap();
        let input = Input::of(&recording, 0).unwrap();
        let refusal = learn(&input, &Question::default()).unwrap_err().to_string();
        assert!(
            refusal.contains("wanted 4 or more: a longer motion"),
            "{name}: {refusal}"
        );
    }
}
