//! `courier diagnose A B … --out DIR`.

use crate::interrupt::{self, EXIT_INTERRUPTED};
use crate::json::Json;
use crate::many::part::ENDING;
use crate::many::{Done, Order, run as diagnose_all};
use crate::output::Kind;
use crate::terminal::progress;
use anyhow::Result;
use std::process::ExitCode;

/// What `--json` writes beside the table.
pub const ANSWER: Kind = Kind::json(
    "a count of diagnoses",
    &["recordings", "already", "verdicts"],
);

/// Diagnoses into the table and says how many were what.
///
/// # Errors
/// The table cannot be written.
pub fn run(order: &Order, json: &Json) -> Result<ExitCode> {
    interrupt::watch()?;
    let bar = progress(order.recordings.len() as u64, "diagnosing: recordings");
    let done = diagnose_all(order, &|| bar.inc(1))?;
    bar.finish_and_clear();
    json.tell(ANSWER, &done, || text(order, &done))?;
    Ok(match done.not_reached {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::from(EXIT_INTERRUPTED),
    })
}

/// What was done, in words.
pub fn text(order: &Order, done: &Done) -> String {
    let one =
        |(verdict, count): (&String, &usize)| format!("{count} {}", verdict.replace('_', " "));
    let mut parts: Vec<String> = done.verdicts.iter().map(one).collect();
    if done.already > 0 {
        parts.push(format!("{} there already", done.already));
    }
    if done.taken_over > 0 {
        parts.push(format!(
            "{} there already under another path",
            done.taken_over
        ));
    }
    if done.not_reached > 0 {
        parts.push(format!("interrupted: {} not reached", done.not_reached));
    }
    format!(
        "{} recordings: {}; rows in {}/courier_id=*/*{ENDING}",
        done.recordings,
        parts.join(", "),
        order.table.display()
    )
}
