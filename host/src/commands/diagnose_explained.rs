//! What `courier diagnose --explain` adds: the steps of the decision, the likeliest sets of effects, and why each lost.

use crate::terminal::table;
use diagnosis::figures::Decision;
use diagnosis::posterior::explained::HEADER;

/// A decision's steps and its likeliest sets, as text.
pub fn text(decision: &Decision) -> String {
    let masses = decision.masses;
    let mut out = format!(
        "probabilities: no gap {:.3}, named {:.3}, unknown {:.3}\n",
        masses.no_gap, masses.named, masses.unknown
    );
    for reason in &decision.reasons {
        out += &format!("  {reason}\n");
    }
    let rows: Vec<Vec<String>> = decision.sets.iter().map(|row| row.cells().into()).collect();
    out + &table(&HEADER, &rows)
}
