//! `courier abort`.

use crate::board::Choice;
use crate::terminal::{print, print_json};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::process::ExitCode;

/// End a self-calibration that is under way; the calibration in force stays.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any abort")]
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
    let Reply::Done = board.link.ask(Action::Abort)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    if args.json {
        print_json(&json!({ "aborted": true }))?;
    } else {
        print("aborted")?;
    }
    Ok(ExitCode::SUCCESS)
}
