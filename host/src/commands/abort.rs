//! `courier abort`.

use crate::board::Choice;
use crate::terminal::print;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// End a self-calibration that is under way; the calibration in force stays.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any abort")]
pub struct Args {}

/// Asks.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(_: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Done = board.link.ask(Action::Abort)? else { bail!(super::STRANGE_REPLY) };
    board.close()?;
    print("aborted")?;
    Ok(ExitCode::SUCCESS)
}
