//! `courier commit`.

use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// Store the calibration that is in force.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any commit")]
pub struct Args {
    /// Overwrite a later firmware's record, if it is in the way.
    #[arg(long)]
    lose_unknown: bool,
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
    let Reply::Place(place) = board.link.ask(Action::Commit {
        lose_unknown: args.lose_unknown,
    })?
    else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    super::print_place("stored", &place, args.json)
}
