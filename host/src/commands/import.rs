//! `courier import FILE`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use crate::calibration_file::{CalibrationFile, check_own_geometry};
use anyhow::{Context, Result, bail};
use courier_sensor::link::message::{Action, Reply};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Put a calibration from a file in force on a board, and store it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin import courier7.json")]
pub struct Args {
    /// The file, as `export` wrote it.
    file: PathBuf,
    /// Put it in force, but do not store it.
    #[arg(long)]
    dry_run: bool,
    /// Take it though it is of another device. From then on it is this board's, and bears its number.
    #[arg(long)]
    other_device: bool,
    /// Take it though its pitch, span, height or lever arm is not what this board was built with. Positions are counted in
    /// its pitch then: one that is 1 % off makes every distance 1 % wrong.
    #[arg(long)]
    other_geometry: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier import`", &["stored"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().reads(&self.file).json(&self.json, ANSWER)
    }
}

/// Checks, loads, stores.
///
/// # Errors
/// The file is no calibration of this device, or the board refuses; what was in force still is.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let calibration = CalibrationFile::read(&args.file)?;
    if !args.other_geometry {
        check_own_geometry(&calibration).with_context(|| args.file.display().to_string())?;
    }
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
    let Reply::Done = board.link.ask(Action::Load { other_device: args.other_device, calibration })? else {
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
    args.json
        .tell(ANSWER, &json!({ "stored": stored }), || match &stored {
            None => "in force, not stored".into(),
            Some(place) => super::place("in force and stored", place),
        })?;
    Ok(ExitCode::SUCCESS)
}
