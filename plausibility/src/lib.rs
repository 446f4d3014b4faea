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
mod fitted;
mod poses;
mod products;
mod quadrature;
mod readings;
mod same;
mod slips;
mod subject;
mod view;
mod wiring;

pub use finding::{Finding, Kind};
pub use fitted::Fitted;
pub use subject::Subject;

use recording::Recording;

/// What the readings say of wires, units and stated geometry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plausibility {
    /// What cannot be as it is stated; empty where all can be.
    pub findings: Vec<Finding>,
    /// What is stated of the geometry and what the data say of it, as far as this motion tells it.
    pub geometry: Vec<Fitted>,
}

/// What cannot be as it is stated. Never fails, and takes well below a second whatever the recording's length.
#[must_use]
pub fn check(recording: &Recording) -> Vec<Finding> {
    look(recording).findings
}

/// The same with the geometry by the data.
#[must_use]
pub fn look(recording: &Recording) -> Plausibility {
    let relations = explain::Relations::of_stated(recording);
    let geometry = relations.geometry();
    let copied = same::copied(recording);
    if !copied.is_empty() {
        let told = |fault| Finding::new(fault, &recording.meta);
        return Plausibility {
            findings: copied.iter().map(told).collect(),
            geometry,
        };
    }
    let explanations = explain::explanations(recording, &relations);
    let told = |e: &explain::Explanation| -> Vec<Finding> {
        e.faults
            .iter()
            .filter(|fault| !fault.of_commands())
            .map(|fault| Finding::new(fault, &recording.meta))
            .collect()
    };
    let mut findings = explanations.first().map(told).unwrap_or_default();
    if let Some(finding) = findings.last_mut() {
        finding.or = explanations.iter().skip(1).map(told).collect();
    }
    Plausibility { findings, geometry }
}
