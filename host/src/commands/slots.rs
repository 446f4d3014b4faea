//! `courier slots`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use crate::terminal::table;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, RecordRefusal, Reply, SlotContent};
use std::process::ExitCode;

/// List what both calibration slots of a board hold.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin slots")]
pub struct Args {
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier slots`", &["slot", "state"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Slots(slots) = board.link.ask(Action::Slots)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    let rows: Vec<Vec<String>> = slots
        .iter()
        .map(|slot| {
            let sequence = slot
                .sequence
                .map_or("-".to_owned(), |sequence| sequence.to_string());
            let state = match slot.state {
                SlotContent::Refused(RecordRefusal::Empty) => "empty".to_owned(),
                SlotContent::Refused(why) => format!("not usable: {why}"),
                usable => usable.to_string(),
            };
            vec![slot.slot.to_string(), sequence, state]
        })
        .collect();
    args.json.tell(ANSWER, &slots, || {
        table(&["slot", "number", "state"], &rows)
    })?;
    Ok(ExitCode::SUCCESS)
}
