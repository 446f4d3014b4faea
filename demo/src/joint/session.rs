//! A joint calibration under the beacon, ordered from the firmware.

use super::options::JointOptions;
use super::poses::Poses;
use crate::standstill;
use anyhow::Result;
use board_link::{Simulated, session};
use courier_sensor::calibration::Stage;
use courier_sensor::calibration::joint::JointConfig;
use courier_sensor::calibration::record::Method;
use courier_sensor::link::message::{Action, CalibrateOrder};
use courier_sensor::link::report::Progress;
use indicatif::ProgressBar;

/// Poses of this system's method lie within half of this to either side of the beacon: over all of the fly-by. The paper's two
/// pitches would leave the coordination sensor's own errors extrapolated fourfold.
pub(super) const TRAVEL_M: f32 = 8.4e-3;

/// A joint calibration within so much of the beacon, its result stored.
pub(super) fn joint_order(options: &JointOptions, travel_m: f32, turn_rad: f32) -> CalibrateOrder {
    let visits = JointConfig::default().visits;
    let poses = options.poses.unwrap_or(visits.poses);
    CalibrateOrder {
        method: Method::Joint,
        poses: poses as u16, // at most 1000
        held_out_poses: visits.held_out_poses.min(poses) as u16,
        seed: options.seed,
        travel_m,
        turn_rad,
        ..CalibrateOrder::default()
    }
}

/// How far a joint session goes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// To its end.
    Solved,
    /// Until its poses have been visited: the calibration in force stays.
    Visited,
}

/// A joint session under the beacon, by the firmware; what was seen at each pose.
pub(super) fn joint(
    board: &mut Simulated,
    order: &CalibrateOrder,
    until: Until,
    progress: &ProgressBar,
) -> Result<(Poses, Progress)> {
    progress.set_message("both sensors: poses");
    let mut poses = Poses::start(board)?;
    let mut is_aborted = false;
    let ended = session::run(board, order, standstill::LOOK, progress, |board, now| {
        poses.look(board, now)?;
        if until == Until::Visited && now.stage == Stage::Solving && !is_aborted {
            is_aborted = true;
            board.link.ask(Action::Abort)?;
        }
        Ok(())
    })?;
    Ok((poses.finish(board)?, ended))
}
