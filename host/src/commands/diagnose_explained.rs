//! What `courier diagnose --explain` adds: the likeliest sets of effects by the posterior, and why each lost.

use crate::terminal::table;
use diagnosis::posterior::diagnosed::Answer;
use diagnosis::posterior::explained::Row;

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
    let rows: Vec<Vec<String>> = answer.sets.iter().map(row).collect();
    out + &table(
        &[
            "set of effects (| what no effect holds, by)",
            "probability",
            "ln evidence",
            "ln prior",
            "ln size",
            "held-out gain",
            "alias",
            "why it is not the first",
        ],
        &rows,
    )
}

fn row(row: &Row) -> Vec<String> {
    let effects = if row.effects.is_empty() {
        "none".to_owned()
    } else {
        row.effects.join(" + ")
    };
    let set = if row.shapes.is_empty() {
        effects
    } else {
        format!("{effects} | {}", row.shapes.join(", "))
    };
    vec![
        set,
        format!("{:.3}", row.probability),
        format!("{:.1}", row.log_evidence),
        format!("{:.1}", row.log_prior),
        format!("{:.1}", row.log_least),
        format!("{:.0}", row.held_out_gain),
        if row.alias { "yes" } else { "" }.to_owned(),
        row.lost.to_owned(),
    ]
}
