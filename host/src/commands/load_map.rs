//! `courier load` of a tooth map.

use super::load::Args;
use crate::board::{Choice, Link, map, motion};
use crate::teeth::MapFile;
use anyhow::{Result, bail, ensure};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::frame::{Pose, Status};
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::link::telemetry::Channels;
use std::process::ExitCode;
use std::time::Duration;

/// One frame in so many is looked at under the beacon, and so many of them: a quarter of a second.
const DECIMATION: u16 = 50;
const LOOKS: usize = 100;
/// Looks at the channels until they must have come.
const PATIENCE: usize = 100;
/// Time between two.
const LOOK: Duration = Duration::from_millis(20);
const CHANNELS: Channels = Channels::STATUS
    .union(Channels::POSE)
    .union(Channels::TAN_PSI);

/// Goes under the beacon, finds by it where the map lies in the board's counts, loads the map's coefficients and the beacon's place
/// in these counts into the calibration in force, stores that unless `dry_run`, and puts the map in force.
///
/// # Errors
/// The board has no calibration, sees no beacon or not the map's, or refuses; a map that was in force may be out of it then, which
/// is told.
pub fn run(file: &MapFile, args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let start = args.from.or(board.beacon);
    let link = &mut board.link;
    let mut calibration = map::in_force(link)?;
    if let Some(target) = start {
        motion::go(link, target, SELF_MOTION_M_PER_S)?;
    }
    let (pose, tan_psi) = stand(link)?;
    let ahead = file.map.anchor.teeth_ahead(&pose, tan_psi)?;
    calibration.model = file.map.model.clone();
    if let Some(beacon) = &mut calibration.beacon {
        let origin = file.map.anchor.origin(ahead, calibration.geometry.lever_m);
        (beacon.origin_teeth, beacon.origin_m) = origin;
    }
    map::load(link, calibration)?;
    let stored = if args.dry_run {
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
    let header = file.header_for(ahead);
    let grids = header.grids;
    map::load_map(link, header, &file.map.nodes_nm)?;
    board.close()?;
    let told = serde_json::json!({ "map": grids, "teeth_ahead": ahead, "stored": stored });
    let [x, y] = grids.map(|grid| grid.nodes);
    let place = stored.map_or("not stored".to_owned(), |place| {
        format!("stored: slot {}, number {}", place.slot, place.sequence)
    });
    args.json.tell(super::load::ANSWER, &told, || format!(
        "coefficients {place}\nby the beacon the board counts {} and {} teeth ahead of the map's recording\ntooth map of {} by {} and {} by {} nodes in force until the board restarts (load it again then) or is calibrated again",
        ahead[0], ahead[1], x[0], x[1], y[0], y[1]
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The last pose of a standstill under the beacon, and the means of tan psi.
fn stand(link: &mut Link) -> Result<(Pose, [f32; 2])> {
    let (mut last, mut sums, mut seen) = (Pose::default(), [0.0; 2], 0);
    link.stream(CHANNELS, DECIMATION)?;
    for _ in 0..PATIENCE {
        link.pass(LOOK)?;
        link.listen(|sample| {
            let status = sample.status.unwrap_or(Status::BEACON_MISSING);
            let doubtful = Status::BEACON_MISSING.union(Status::BEACON_SATURATED);
            if let (Some(pose), Some(tan_psi), false) =
                (sample.pose, sample.tan_psi, status.intersects(doubtful))
            {
                last = pose;
                (0..2).for_each(|axis| sums[axis] += tan_psi[axis]);
                seen += 1;
            }
            Ok(())
        })?;
        if seen >= LOOKS {
            break;
        }
    }
    link.stream(Channels::empty(), 0)?;
    ensure!(
        seen >= LOOKS,
        "the board: found the beacon in {seen} frames, wanted {LOOKS}: a map is placed by its beacon (--from goes there)"
    );
    Ok((last, sums.map(|sum| sum / seen as f32)))
}
