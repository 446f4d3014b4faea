//! `courier rollback`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// Go back to the stored calibration before the one in force.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin rollback")]
pub struct Args {
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier rollback`", &["slot", "sequence"]);

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
    let Reply::Place(place) = board.link.ask(Action::RollBack)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    args.json
        .tell(ANSWER, &place, || super::place("in force again", &place))?;
    Ok(ExitCode::SUCCESS)
}
