//! `courier reset`.

use crate::board::Choice;
use crate::terminal::print;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// Restart a board; it comes up with what is stored.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any reset")]
pub struct Args {}

/// Asks.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(_: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Done = board.link.ask(Action::Restart)? else { bail!(super::STRANGE_REPLY) };
    board.close()?;
    print("restarting")?;
    Ok(ExitCode::SUCCESS)
}
