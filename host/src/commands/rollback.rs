//! `courier rollback`.

use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// Go back to the stored calibration before the one in force.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any rollback")]
pub struct Args {
    /// Print JSON instead of a sentence.
    #[arg(long)]
    json: bool,
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
    super::print_place("in force again", &place, args.json)
}
