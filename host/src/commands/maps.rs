//! `courier maps`.

use super::maps_mark;
use crate::board::{Choice, map};
use crate::json::Json;
use crate::kinds;
use crate::output::{Files, Kind};
use crate::terminal::{micrometres, table};
use anyhow::{Result, bail};
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Coordinate;
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::maps::{MapRecordError, MapSlot, MapSlotState, SLOTS};
use std::path::PathBuf;
use std::process::ExitCode;

/// List the tooth maps that a board keeps, or forget one.
///
/// A board keeps the maps of three places. `courier load MAP.json` stores one; of a place that has one already it is replaced.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin maps")]
pub struct Args {
    /// Forget the map in this slot. One that is in force stays so until the board restarts.
    #[arg(long, value_name = "SLOT", value_parser = clap::value_parser!(u8).range(0..SLOTS as i64))]
    forget: Option<u8>,
    /// Write where the courier stands, at a reference mark or an end stop, in the count of the stored map that is in force by its beacon.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["forget", "at_mark"])]
    learn_mark: Option<PathBuf>,
    /// The courier stands at that mark, turned as it was: put the map in force by it, where no beacon is.
    #[arg(long, value_name = "FILE", conflicts_with = "forget")]
    at_mark: Option<PathBuf>,
    /// Move the courier there over the board's own reference mark, at 8 mm/s: mm, mm and degrees in the motion controller's frame.
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target, conflicts_with_all = ["forget", "learn_mark", "at_mark"])]
    cross: Option<Target>,
    /// The board keeps where it has crossed its own reference mark, in the count of the stored map in force: at later starts the mark puts that
    /// map in force, without a host.
    #[arg(long, conflicts_with_all = ["forget", "learn_mark", "at_mark"])]
    keep_mark: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier maps`", &["slot", "state", "info"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default().json(&self.json, ANSWER).writes(self.learn_mark.as_ref(), kinds::MARK);
        match &self.at_mark { Some(path) => files.reads(path), None => files }
    }
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    if let Some(slot) = args.forget {
        let Reply::Done = board.link.ask(Action::MapForget(slot))? else {
            bail!(super::STRANGE_REPLY)
        };
    }
    let marked = match (&args.learn_mark, &args.at_mark) {
        (Some(path), _) => Some(maps_mark::learn(&mut board.link, path)?),
        (None, Some(path)) => Some(maps_mark::home(&mut board.link, path)?),
        (None, None) => maps_mark::own(&mut board.link, args.cross, args.keep_mark)?,
    };
    let slots = (0..SLOTS as u8).map(|slot| map::slot(&mut board.link, slot));
    let slots: Vec<MapSlot> = slots.collect::<Result<_>>()?;
    board.close()?;
    let rows: Vec<Vec<String>> = slots.iter().map(row).collect();
    let marked = marked.map_or(String::new(), |line| line + "\n");
    args.json.tell(ANSWER, &slots, || marked + &table(&["slot", "place", "g_p left", "mark", "state"], &rows))?;
    Ok(ExitCode::SUCCESS)
}

fn row(slot: &MapSlot) -> Vec<String> {
    let state = match slot.state {
        MapSlotState::Refused(MapRecordError::Empty) => "empty".to_owned(),
        MapSlotState::Refused(why) => format!("not usable: {why}"),
        other => other.to_string(),
    };
    let [place, left] = match &slot.info {
        Some(info) => [info.name.to_string(), format!("{} µm", micrometres(info.parity_m.into()))],
        None => ["-".to_owned(), "-".to_owned()],
    };
    vec![slot.slot.to_string(), place, left, mark(slot.mark), state]
}

/// Where the board's own reference mark is crossed, in teeth of the map's count.
fn mark(kept: Option<[Coordinate; 2]>) -> String {
    kept.map_or_else(|| "-".to_owned(), |place| {
        let [x, y] = place.map(|along| f64::from(along.teeth) + f64::from(along.fraction_turns));
        format!("teeth {x:.2}, {y:.2}")
    })
}
