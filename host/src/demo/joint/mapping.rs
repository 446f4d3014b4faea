//! The tooth map's part of the demonstration: more poses, the estimate, and the map in force.

use super::super::flight::stand_at;
use super::report::JointReport;
use super::run::{COMMIT, JointOptions, TRAVEL_M, in_force, joint};
use crate::teeth::{Setup, TeethPose, estimate};
use anyhow::Result;
use courier_sensor::app::background::Errand;
use courier_sensor::calibration::joint::JointConfig;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::settings::Settings;
use effects::motion::Pose;
use hal_sim::board::SimBoard;
use indicatif::ProgressBar;

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
    board: &mut SimBoard,
    options: &JointOptions,
    mut poses: Vec<TeethPose>,
    beacon: Pose,
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<()> {
    let calibrated_jointly = in_force(board)?;
    stand_at(board, beacon)?;
    let errand = Errand {
        commit: false,
        ..COMMIT
    };
    for seed in MAP_SEEDS {
        let more = JointOptions {
            seed: options.seed ^ seed,
            ..options.clone()
        };
        let (seen, _) = joint(board, &more, (TRAVEL_M, MAP_TURN_RAD), errand, progress)?;
        poses.extend(seen.teeth);
        stand_at(board, beacon)?;
    }
    let frames = f64::from(JointConfig::default().frames_per_pose).sqrt();
    let noise_m = FRAME_NOISE_M.map(|noise_m| noise_m / frames);
    let setup = Setup::entered(&Settings::default().geometry, noise_m[0], noise_m[1]);
    progress.set_message("tooth map");
    progress.set_position(0);
    let mapped = estimate(&setup, &poses, &mut || progress.inc(1));
    let model = match &mapped {
        Ok(mapped) => mapped.model.clone(),
        Err(why) => {
            report.map_refusal = Some(why.to_string());
            calibrated_jointly.model.clone()
        }
    };
    board.sample();
    board.background.keeper_mut()?.load(&Calibration {
        model,
        ..calibrated_jointly
    })?;
    if let Ok(mapped) = mapped {
        board.sample();
        let keeper = board.background.keeper_mut()?;
        keeper.map_begin(&mapped.header)?;
        keeper.map_nodes(&mapped.nodes_nm)?;
        keeper.map_apply()?;
        report.map = Some(mapped.evidence);
    }
    Ok(())
}
