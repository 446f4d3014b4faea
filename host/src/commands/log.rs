//! `courier log`.

use crate::output::{Files, Kind as FileKind};
use crate::board::{Choice, Kind, Link, chip, emulated};
use crate::json::Lines;
use crate::live::Live;
use crate::terminal::warn;
use anyhow::{Context, Result, bail, ensure};
use courier_sensor::link::message::LOG_CHANNEL;
use defmt_decoder::{DecodeError, Frame, Locations, Table};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Show a board's log: start-up, faults, changes of state.
///
/// As it comes, the board sends numbers for texts; the texts are in its image, which has to be the one that it runs. With --kept, what it
/// has kept in flash over its restarts: their causes, faults, calibrations, tooth maps, what the watch has found, new firmware.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  courier --emulated log --seconds 1\n  courier --sim-flash board.bin log --kept")]
pub struct Args {
    /// Show what the board has kept in flash, oldest first.
    #[arg(long, conflicts_with_all = ["elf", "seconds"])]
    kept: bool,
    /// The image that the board runs [default: the one that `cargo xtask firmware` builds].
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    #[command(flatten)]
    live: Live,
}

/// What `--json` writes.
const LINES: FileKind = FileKind::Lines { what: "lines of `courier log`", keys: &["level", "message"] };

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default().json(&self.live.json, LINES);
        match &self.elf { Some(path) => files.reads(path), None => files }
    }
}

/// One line of `--json`.
#[derive(Serialize)]
struct Line {
    level: String,
    message: String,
    file: Option<String>,
    line: Option<u64>,
}

/// Reads, decodes, prints.
///
/// # Errors
/// The board has no log or cannot be reached, or the image is none or has no texts.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    if args.kept {
        return super::log_kept::run(&args.live.json, choice);
    }
    args.live.seconds()?;
    let path = match (&args.elf, choice.kind()) {
        (_, Kind::Sim) => bail!(
            "log: found the simulated board, which has none that goes by: its firmware runs in this process; wanted --emulated, --chip or --probe, or --kept for what it keeps in flash"
        ),
        (Some(path), _) => path.clone(),
        (None, Kind::Emulated) => emulated::images()?.firmware,
        (None, Kind::Chip) => chip::image()?,
        (None, Kind::Probe) => emulated::built("g474.elf"),
    };
    let image = Image::read(&path)?;
    let mut board = choice.open()?;
    let mut decoder = image.table.new_stream_decoder();
    let mut lines = args.live.json.lines()?;
    args.live.watch(&mut board.link, |link| {
        decoder.received(&read(link)?);
        loop {
            match decoder.decode() {
                Ok(frame) => image.show(&frame, &mut lines)?,
                Err(DecodeError::UnexpectedEof) => return Ok(()),
                Err(DecodeError::Malformed) => {
                    warn("the log: found what the image has no text for; is it the one that the board runs?");
                    ensure!(image.table.encoding().can_recover(), "the log: found a broken frame, wanted one of this image");
                }
            }
        }
    })?;
    board.close()?;
    Ok(ExitCode::SUCCESS)
}

fn read(link: &mut Link) -> Result<Vec<u8>> {
    let mut bytes = vec![0; 1024];
    let taken = link.wire().receive(LOG_CHANNEL, &mut bytes)?;
    bytes.truncate(taken);
    Ok(bytes)
}

/// The texts of an image.
struct Image {
    table: Table,
    places: Locations,
}

impl Image {
    fn read(path: &Path) -> Result<Self> {
        let wanted = || format!("{}: an image of this firmware was wanted", path.display());
        let bytes = std::fs::read(path).with_context(wanted)?;
        let table = Table::parse(&bytes).with_context(wanted)?;
        let table = table
            .context("no log texts are in it")
            .with_context(wanted)?;
        let places = table.get_locations(&bytes).with_context(wanted)?;
        Ok(Self { table, places })
    }

    fn show(&self, frame: &Frame<'_>, lines: &mut Lines) -> Result<()> {
        let place = self.places.get(&frame.index());
        let line = Line {
            level: frame.level().map_or("-", |level| level.as_str()).to_owned(),
            message: frame.display_message().to_string(),
            file: place.map(|place| place.file.display().to_string()),
            line: place.map(|place| place.line),
        };
        let place = match (&line.file, line.line) {
            (Some(file), Some(number)) => format!("  ({file}:{number})"),
            _ => String::new(),
        };
        lines.push(&line, || format!("{:<5} {}{place}", line.level, line.message))
    }
}
