//! `courier reset`.

use crate::board::Choice;
use crate::terminal::{print, print_json};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::process::ExitCode;

/// Restart a board; it comes up with what is stored.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any reset")]
pub struct Args {
    /// Print JSON instead of a sentence.
    #[arg(long)]
    json: bool,
}

/// Asks.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Done = board.link.ask(Action::Restart)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    if args.json {
        print_json(&json!({ "restarting": true }))?;
    } else {
        print("restarting")?;
    }
    Ok(ExitCode::SUCCESS)
}
