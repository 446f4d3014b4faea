//! A calibration or a tooth map into a board's memory.

use crate::Link;
use anyhow::{Result, bail};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::{Action, MAP_NODES_A_COMMAND, MapPlace, Reply, Source};
use courier_sensor::maps::MapSlot;
use courier_sensor::teeth::MapHeader;
use std::time::Duration;

/// The interrupt takes what was put in force, and gives back what was before, at its next sample.
const A_SAMPLE: Duration = Duration::from_millis(1);

/// The calibration in force.
///
/// # Errors
/// There is none, or the board cannot be reached.
pub fn in_force(link: &mut Link) -> Result<Calibration> {
    match link.ask(Action::Read(Source::InForce))? {
        Reply::Calibration(calibration) => Ok(calibration),
        _ => bail!("the board: found a strange reply to a question for its calibration"),
    }
}

/// Puts a calibration in force, not stored; a map that was in force is out of it then.
///
/// # Errors
/// The board refuses it or cannot be reached.
pub fn load(link: &mut Link, calibration: Calibration) -> Result<()> {
    done(link, Action::load(calibration))?;
    link.pass(A_SAMPLE)
}

/// Puts a tooth map in force.
///
/// # Errors
/// The board refuses it or cannot be reached.
pub fn load_map(link: &mut Link, header: MapHeader, nodes_nm: &[i16]) -> Result<()> {
    done(link, Action::MapBegin(header))?;
    for nodes in nodes_nm.chunks(MAP_NODES_A_COMMAND) {
        done(link, Action::MapNodes(nodes.iter().copied().collect()))?;
    }
    done(link, Action::MapApply)
}

/// Stores a tooth map with the error model in force, for the stored calibration, which is in force then; the board looks for the map's
/// beacon. Its slot.
///
/// # Errors
/// The board refuses it or cannot be reached.
pub fn store_map(
    link: &mut Link,
    place: MapPlace,
    header: MapHeader,
    nodes_nm: &[i16],
) -> Result<MapSlot> {
    done(link, Action::MapStore { place, header })?;
    for nodes in nodes_nm.chunks(MAP_NODES_A_COMMAND) {
        done(link, Action::MapStoreNodes(nodes.iter().copied().collect()))?;
    }
    match link.ask(Action::MapStoreEnd)? {
        Reply::MapSlot(slot) => Ok(slot),
        _ => bail!("the board: found a strange reply to a map that was stored"),
    }
}

/// What a slot for tooth maps holds.
///
/// # Errors
/// The board cannot be reached.
pub fn slot(link: &mut Link, slot: u8) -> Result<MapSlot> {
    match link.ask(Action::MapSlot(slot))? {
        Reply::MapSlot(slot) => Ok(slot),
        _ => bail!("the board: found a strange reply to a question for a map"),
    }
}

fn done(link: &mut Link, action: Action) -> Result<()> {
    match link.ask(action)? {
        Reply::Done => Ok(()),
        _ => bail!("the board: found a strange reply to an order to load"),
    }
}
