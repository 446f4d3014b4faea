//! What a recording's readings say against its wires, units and stated values, told wherever readings are used.

use crate::terminal::warn;
use anyhow::{Result, ensure};
use plausibility::{Finding, Subject};
use recording::Recording;

/// What a command computes with: where one of these is wrong, nothing useful can come of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uses(&'static [Subject]);

/// The readings are kept as they are: nothing is computed.
pub const NOTHING: Uses = Uses(&[]);
/// The segments against each other.
pub const SEGMENTS: Uses = Uses(&[Subject::Segments]);
/// The segments against each other or a reference.
pub const SEGMENTS_AND_REFERENCE: Uses = Uses(&[Subject::Segments, Subject::Reference]);
/// The segments and the coordination sensor.
pub const BOTH_SENSORS: Uses = Uses(&[Subject::Segments, Subject::Span, Subject::Coordination]);
/// Everything.
pub const ALL: Uses = Uses(&[
    Subject::Segments,
    Subject::Span,
    Subject::Coordination,
    Subject::Reference,
]);

/// Holds readings against their wires, units and stated values. What is wrong and is not used is told in a line on standard error
/// and returned. `place` is where the readings come from.
///
/// # Errors
/// Something that is used cannot be right; the line says what would be.
pub fn check(recording: &Recording, place: &str, uses: Uses) -> Result<Vec<Finding>> {
    check_telling(recording, place, uses, &mut warn)
}

/// The same; what is wrong and is not used is told to `tell`, a line each.
///
/// # Errors
/// As [`check`].
pub fn check_telling(
    recording: &Recording,
    place: &str,
    uses: Uses,
    tell: &mut dyn FnMut(&str),
) -> Result<Vec<Finding>> {
    let (used, unused) = sorted(recording, uses);
    unused.iter().for_each(|finding| tell(&finding.to_string()));
    ensure!(used.is_empty(), "{}", refusal(place, &used));
    Ok(unused)
}

/// What is wrong with what is used, and what is wrong with the rest.
pub fn sorted(recording: &Recording, uses: Uses) -> (Vec<Finding>, Vec<Finding>) {
    plausibility::check(recording)
        .into_iter()
        .partition(|finding| finding.is_about(uses.0))
}

/// Why readings from a place are refused.
pub fn refusal(place: &str, used: &[Finding]) -> String {
    let told: Vec<String> = used.iter().map(Finding::to_string).collect();
    format!(
        "{place}: found that {}; wanted wires, units and geometry that fit the readings",
        told.join("; and that ")
    )
}
