//! What a recording's readings say against its wires, units and stated values, told wherever one is read.

use crate::terminal::warn;
use plausibility::Finding;
use recording::Recording;

/// Tells each finding in a line on standard error, and returns them.
pub fn warn_of(recording: &Recording) -> Vec<Finding> {
    let findings = plausibility::check(recording);
    findings
        .iter()
        .for_each(|finding| warn(&finding.to_string()));
    findings
}
