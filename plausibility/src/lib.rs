//! Whether wires, units and stated geometry of a recording can be right, by its readings alone.
//!
//! A courier measures its pose more than once: four segments tell three coordinates (equations 4 to 6), the coordination sensor two of them
//! again (equations 10 and 11), a reference or the commands once more. An exchanged wire, a wrong sign or a value in the wrong unit breaks
//! such a relation by far more than any error of a sensor. [`check`] looks for the fewest faults that mend all of them. What this motion
//! cannot tell is not told: without turning no lever arm, without a beacon no height.
//!
//! A recording that is right gives an empty list, whatever the sensor's own errors are.

mod diode;
mod explain;
mod fault;
mod finding;
mod poses;
mod products;
mod quadrature;
mod readings;
mod same;
mod view;
mod wiring;

pub use finding::{Finding, Kind};

use recording::Recording;

/// What cannot be as it is stated. Never fails, and takes well below a second whatever the recording's length.
#[must_use]
pub fn check(recording: &Recording) -> Vec<Finding> {
    let copied = same::copied(recording);
    if !copied.is_empty() {
        return copied
            .iter()
            .map(|fault| Finding::new(fault, &recording.meta))
            .collect();
    }
    let explanations = explain::explanations(recording);
    let told = |e: &explain::Explanation| -> Vec<Finding> {
        e.faults
            .iter()
            .filter(|fault| !fault.of_commands())
            .map(|fault| Finding::new(fault, &recording.meta))
            .collect()
    };
    let Some((first, others)) = explanations.split_first() else {
        return Vec::new();
    };
    let mut findings = told(first);
    if let Some(finding) = findings.last_mut() {
        finding.or = others.iter().map(told).collect();
    }
    findings
}
