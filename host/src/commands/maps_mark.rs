//! Whole teeth by a reference mark or an end stop: of the motion controller (`courier maps --learn-mark`, `--at-mark`), or of the board
//! (`--cross`, `--keep-mark`).

use super::status_map;
use crate::board::{Link, map};
use crate::kinds;
use crate::output;
use anyhow::{Context, Result, bail, ensure};
use board_link::motion;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Coordinate;
use courier_sensor::link::message::{Action, Reply, StoredMap};
use courier_sensor::maps::mark;
use courier_sensor::maps::{MapSlotState, SLOTS};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Duration;

/// Version of the file.
const SCHEMA: u16 = 1;

/// Over a mark, m/s: below the fastest at which the board takes its place, 10 mm/s.
const CROSSING_M_S: f32 = 0.008;
/// From the end of the way to the map in force under its beacon: twice a window.
const FOUND: Duration = Duration::from_millis(500);

/// A mark's file: its one object.
#[derive(Debug, Serialize, Deserialize)]
pub struct MarkFile {
    /// Version.
    courier_mark: u16,
    /// Name of the place whose map it is for.
    place: String,
    /// The mark's place in the map's count: along x and y.
    mark: [Coordinate; 2],
}

/// Writes where the courier stands, in the count of the map in force.
///
/// # Errors
/// No stored map is in force, the courier moves, or the file cannot be written.
pub fn learn(link: &mut Link, path: &Path) -> Result<String> {
    let status = link.status()?;
    let StoredMap::InForce { slot, ahead, .. } = status.stored_map else {
        bail!(
            "found no stored tooth map in force, wanted one, by its beacon: the mark is learned in its count"
        );
    };
    ensure!(
        !status.moving,
        "found the courier moving, wanted it at rest at the mark"
    );
    let info = map::slot(link, slot)?
        .info
        .context("the map has gone meanwhile")?;
    let file = MarkFile {
        courier_mark: SCHEMA,
        place: info.name.to_string(),
        mark: mark::place([status.pose.x, status.pose.y], ahead),
    };
    let text = serde_json::to_string_pretty(&file)? + "\n";
    output::write(path, kinds::MARK, text.as_bytes())?;
    Ok(format!(
        "the mark of {} is written to {}",
        file.place,
        path.display()
    ))
}

/// Says to the board that the courier stands at the mark.
///
/// # Errors
/// The file is none, the board has no map of its place, or refuses.
pub fn home(link: &mut Link, path: &Path) -> Result<String> {
    let name = path.display();
    let wanted = || format!("{name}: a mark by `courier maps --learn-mark` was wanted");
    let text = std::fs::read_to_string(path).with_context(wanted)?;
    let file: MarkFile = serde_json::from_str(&text).with_context(wanted)?;
    ensure!(
        file.courier_mark == SCHEMA,
        "{name}: courier_mark: found {}, wanted {SCHEMA}",
        file.courier_mark
    );
    let is_possible = file
        .mark
        .iter()
        .all(|place| place.fraction_turns.abs() <= 1.0);
    ensure!(
        is_possible,
        "{name}: mark: found a part of a tooth beyond one tooth, wanted at most 1"
    );
    for slot in 0..SLOTS as u8 {
        let found = map::slot(link, slot)?;
        let is_its = found
            .info
            .is_some_and(|info| info.name == file.place.as_str());
        if is_its && found.state == MapSlotState::Current {
            let mark = file.mark;
            let Reply::Done = link.ask(Action::MapAtMark { slot, mark })? else {
                bail!(super::STRANGE_REPLY)
            };
            return Ok(format!("tooth map of {} in force by its mark", file.place));
        }
    }
    bail!(
        "{name}: place: found no tooth map of {} on the board, wanted one: `courier maps` lists them",
        file.place
    )
}

/// Moves the courier over the board's own mark, and has the place kept. What has become of the stored map, if anything was asked.
///
/// # Errors
/// The motion controller does not get there, or the board refuses.
pub fn own(link: &mut Link, cross: Option<Target>, keep: bool) -> Result<Option<String>> {
    if let Some(target) = cross {
        motion::go(link, target, CROSSING_M_S)?;
        link.pass(FOUND)?;
    }
    if keep {
        let Reply::Done = link.ask(Action::MapKeepMark)? else {
            bail!(super::STRANGE_REPLY)
        };
    }
    if cross.is_none() && !keep {
        return Ok(None);
    }
    let state = link.status()?.stored_map;
    let name = match status_map::slot(&state) {
        Some(slot) => map::slot(link, slot)?.info.map(|info| info.name),
        None => None,
    };
    let kept = if keep {
        "the mark's place is kept; "
    } else {
        ""
    };
    let told = status_map::text(&state, name.as_deref());
    Ok(Some(format!("{kept}stored maps: {told}")))
}
