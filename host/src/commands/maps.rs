//! `courier maps`.

use crate::board::{Choice, map};
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::terminal::{micrometres, table};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::maps::{MapRecordError, MapSlot, MapSlotState, SLOTS};
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
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier maps`", &["slot", "state", "info"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
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
    let slots = (0..SLOTS as u8).map(|slot| map::slot(&mut board.link, slot));
    let slots: Vec<MapSlot> = slots.collect::<Result<_>>()?;
    board.close()?;
    let rows: Vec<Vec<String>> = slots.iter().map(row).collect();
    args.json.tell(ANSWER, &slots, || table(&["slot", "place", "g_p left", "state"], &rows))?;
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
    vec![slot.slot.to_string(), place, left, state]
}
