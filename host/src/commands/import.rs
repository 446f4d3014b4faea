//! `courier import FILE`.

use crate::board::Choice;
use crate::calibration_file::CalibrationFile;
use crate::terminal::{print, print_json};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Put a calibration from a file in force on a board, and store it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any import courier7.json")]
pub struct Args {
    /// The file, as `export` wrote it.
    file: PathBuf,
    /// Put it in force, but do not store it.
    #[arg(long)]
    dry_run: bool,
    /// Take it though it was made on another device.
    #[arg(long)]
    other_device: bool,
    /// Print JSON instead of a sentence.
    #[arg(long)]
    json: bool,
}

/// Checks, loads, stores.
///
/// # Errors
/// The file is no calibration of this device, or the board refuses; what was in force still is.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let calibration = CalibrationFile::read(&args.file)?;
    let mut board = choice.open()?;
    let device = board.link.hello().device;
    if calibration.device != device && !args.other_device {
        bail!(
            "{}: found device {}, wanted {} (or --other-device)",
            args.file.display(),
            calibration.device,
            device
        );
    }
    let Reply::Done = board.link.ask(Action::Load(calibration))? else {
        bail!(super::STRANGE_REPLY)
    };
    let mut stored = None;
    if !args.dry_run {
        let Reply::Place(place) = board.link.ask(Action::Commit {
            lose_unknown: false,
        })?
        else {
            bail!(super::STRANGE_REPLY)
        };
        stored = Some(place);
    }
    board.close()?;
    match stored {
        stored if args.json => print_json(&json!({ "stored": stored }))?,
        None => print("in force, not stored")?,
        Some(place) => print(&format!(
            "in force and stored: slot {}, number {}",
            place.slot, place.sequence
        ))?,
    }
    Ok(ExitCode::SUCCESS)
}
