//! `courier export FILE`.

use crate::json::Json;
use crate::kinds;
use crate::output::{self, Files, Kind, new_file};
use crate::board::Choice;
use crate::calibration_file::CalibrationFile;
use crate::terminal::print;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply, Source};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a board's calibration into a file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin export courier7.json")]
pub struct Args {
    /// The file, JSON; `-` for standard output. A file that is there already is not overwritten without --force.
    file: PathBuf,
    /// The slot to read instead of what is in force, 0 or 1.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=1))]
    slot: Option<u8>,
    /// Overwrite the file.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier export`", &["written"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().writes_new(Some(&self.file), kinds::CALIBRATION, self.force).json(&self.json, ANSWER)
    }
}

/// Reads and writes.
///
/// # Errors
/// The board cannot be reached or has no calibration, or the file cannot be written.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let source = args.slot.map_or(Source::InForce, Source::Slot);
    let Reply::Calibration(calibration) = board.link.ask(Action::Read(source))? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    let text = CalibrationFile::new(calibration).to_json()?;
    if args.file.as_os_str() == "-" {
        print(&text)?;
        return Ok(ExitCode::SUCCESS);
    }
    let bytes = format!("{text}\n");
    if args.force {
        output::write(&args.file, kinds::CALIBRATION, bytes.as_bytes())?;
    } else {
        new_file(&args.file, bytes.as_bytes())?;
    }
    args.json.tell(ANSWER, &json!({ "written": args.file }), || {
        format!("written to {}", args.file.display())
    })?;
    Ok(ExitCode::SUCCESS)
}
