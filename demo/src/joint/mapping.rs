//! The tooth map's part of the demonstration: more poses, the estimate, and the map in force.

use super::options::JointOptions;
use super::poses::AVERAGED;
use super::report::JointReport;
use super::session::{TRAVEL_M, Until, joint, joint_order};
use super::steps::Step;
use crate::flight::stand_at;
use anyhow::Result;
use board_link::{Simulated, map};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::CalibrateOrder;
use courier_sensor::settings::Settings;
use effects::motion::Pose;
use indicatif::ProgressBar;
use tooth_map::{Setup, TeethPose, estimate};

/// Angle of the map's further poses, either way: at the end of the lever arm it carries the platen sensor over lines beyond the
/// fly-by's, which tell the map's scale and bend. 2.75°.
const MAP_TURN_RAD: f32 = 48.0e-3;
/// Draw the map's further poses, three times as many as the joint calibration's.
const MAP_SEEDS: [u64; 3] = [0x7ee7_0000, 0x7ee8_0000, 0x7ee9_0000];
/// One frame's noise of a segment and of a displacement, as the board's electronics state it: 20 of 20,000 counts, 2 of 30,000.
const FRAME_NOISE_M: [f64; 2] = [0.16e-6, 0.5e-6];

/// The tooth map: estimated from the joint calibration's poses and further ones over the same area, and put in force.
/// Where held-out poses do not want one the report says so, and none is in force.
pub(super) fn map_teeth(
    board: &mut Simulated,
    options: &JointOptions,
    mut poses: Vec<TeethPose>,
    beacon: Pose,
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<()> {
    for seed in MAP_SEEDS {
        Step::MapPoses.begin(progress, "going under the beacon");
        stand_at(board, beacon)?;
        let order = CalibrateOrder {
            seed: options.seed ^ seed,
            ..joint_order(options, TRAVEL_M, MAP_TURN_RAD)
        };
        let (seen, _) = joint(board, &order, Until::Visited, progress)?;
        poses.extend(seen.teeth);
    }
    let noise_m = FRAME_NOISE_M.map(|noise_m| noise_m / f64::from(AVERAGED).sqrt());
    let setup = Setup::entered(&Settings::default().geometry, noise_m[0], noise_m[1]);
    Step::Map.begin(progress, "tooth map");
    progress.set_position(0);
    match estimate(&setup, &poses, &mut || progress.inc(1)) {
        Ok(mapped) => {
            let calibration = Calibration {
                model: mapped.model,
                ..map::in_force(&mut board.link)?
            };
            map::load(&mut board.link, calibration)?;
            map::load_map(&mut board.link, mapped.header, &mapped.nodes_nm)?;
            report.map = Some(mapped.evidence);
        }
        Err(why) => report.map_refusal = Some(why.to_string()),
    }
    Ok(())
}
