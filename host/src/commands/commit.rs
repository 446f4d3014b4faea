//! `courier commit`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// Store the calibration that is in force.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin commit")]
pub struct Args {
    /// Overwrite a later firmware's record, if it is in the way.
    #[arg(long)]
    lose_unknown: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier commit`", &["slot", "sequence"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached or refuses; what was in force still is.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Place(place) = board.link.ask(Action::Commit {
        lose_unknown: args.lose_unknown,
    })?
    else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    args.json
        .tell(ANSWER, &place, || super::place("stored", &place))?;
    Ok(ExitCode::SUCCESS)
}
