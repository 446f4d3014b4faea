//! `courier abort`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::process::ExitCode;

/// End a self-calibration that is under way; the calibration in force stays.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier abort")]
pub struct Args {
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier abort`", &["aborted"]);

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
    let Reply::Done = board.link.ask(Action::Abort)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    let told = json!({ "aborted": true });
    args.json.tell(ANSWER, &told, || "aborted".into())?;
    Ok(ExitCode::SUCCESS)
}
