//! `courier reset`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::process::ExitCode;

/// Restart a board; it comes up with what is stored.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier reset")]
pub struct Args {
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier reset`", &["restarting"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
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
    let told = json!({ "restarting": true });
    args.json.tell(ANSWER, &told, || "restarting".into())?;
    Ok(ExitCode::SUCCESS)
}
