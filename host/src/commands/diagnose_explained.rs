//! What `courier diagnose --explain` adds: the likeliest sets of effects by the posterior, and why each lost.

use crate::terminal::table;
use diagnosis::posterior::diagnosed::Answer;
use diagnosis::posterior::explained::HEADER;

/// The posterior's steps and its likeliest sets, as text.
pub fn text(answer: &Answer) -> String {
    let masses = answer.masses;
    let mut out = format!(
        "by the posterior, which does not make the verdict yet: no gap {:.3}, named {:.3}, unknown {:.3}\n",
        masses.no_gap, masses.named, masses.unknown
    );
    for reason in &answer.reasons {
        out += &format!("  {reason}\n");
    }
    let rows: Vec<Vec<String>> = answer.sets.iter().map(|row| row.cells().into()).collect();
    out + &table(&HEADER, &rows)
}
