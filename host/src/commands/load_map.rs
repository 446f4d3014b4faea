//! `courier load` of a tooth map.

use crate::board::{Choice, Link};
use crate::teeth::MapFile;
use crate::terminal::{print, print_json};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, MAP_NODES_A_COMMAND, Reply, Source};
use std::process::ExitCode;
use std::time::Duration;

/// The interrupt gives a map back at its next sample.
const A_SAMPLE: Duration = Duration::from_millis(1);

/// Loads the map's coefficients into the calibration in force, stores that unless `dry_run`, and puts the map in force.
///
/// # Errors
/// The board has no calibration or refuses; a map that was in force may be out of it then, which is told.
pub fn run(file: &MapFile, dry_run: bool, json: bool, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let link = &mut board.link;
    let Reply::Calibration(mut calibration) = link.ask(Action::Read(Source::InForce))? else {
        bail!(super::STRANGE_REPLY)
    };
    calibration.model = file.model.clone();
    done(link, Action::Load(calibration))?;
    let stored = if dry_run {
        None
    } else {
        let Reply::Place(place) = link.ask(Action::Commit {
            lose_unknown: false,
        })?
        else {
            bail!(super::STRANGE_REPLY)
        };
        Some(place)
    };
    link.pass(A_SAMPLE)?;
    send(link, file)?;
    board.close()?;
    if json {
        print_json(&serde_json::json!({ "map": file.header.grids, "stored": stored }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [x, y] = file.header.grids.map(|grid| grid.nodes);
    let place = stored.map_or("not stored".to_owned(), |place| {
        format!("stored: slot {}, number {}", place.slot, place.sequence)
    });
    print(&format!(
        "coefficients {place}\ntooth map of {} by {} and {} by {} nodes in force until the board restarts or is calibrated again",
        x[0], x[1], y[0], y[1]
    ))?;
    Ok(ExitCode::SUCCESS)
}

fn send(link: &mut Link, file: &MapFile) -> Result<()> {
    done(link, Action::MapBegin(file.header.clone()))?;
    for nodes in file.nodes_nm.chunks(MAP_NODES_A_COMMAND) {
        done(link, Action::MapNodes(nodes.iter().copied().collect()))?;
    }
    done(link, Action::MapApply)
}

fn done(link: &mut Link, action: Action) -> Result<()> {
    let Reply::Done = link.ask(action)? else {
        bail!(super::STRANGE_REPLY)
    };
    Ok(())
}
