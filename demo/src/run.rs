//! The steps, each ordered over the debug link of a board, simulated or emulated.

use super::flight::fly_along;
use super::flyby::{Deviations, Flyby};
use super::linked;
use super::options::{Options, Plan};
use super::record::Recorder;
use super::report::Report;
use super::standstill;
use super::still::StillPoses;
use anyhow::{Context, Result, bail};
use board_link::{Simulated, session};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::slots::Place;
use courier_sensor::calibration::{self, SessionConfig};
use courier_sensor::link::message::{CalibrateOrder, InForce};
use courier_sensor::link::report::Ending;
use effects::motion::Pose;
use hal_sim::trajectory::{FLYBY_M, FLYBY_SPEED_M_S};
use indicatif::ProgressBar;

/// Boot, self-motions, calibration, storage, restart, fly-by.
///
/// # Errors
/// Options that make no courier, a board that does not start, a motion that never ends, a recording that cannot be written.
/// A calibration that the firmware refuses is no error: the report says so.
pub fn run(options: &Options, progress: &ProgressBar) -> Result<Report> {
    let spec = options
        .preset
        .courier(options.seed, options.waveforms.as_deref(), options.rms_m)?;
    let mut recorder = Recorder::create(options.record.as_ref(), &spec)?;
    let mut report = Report::new(options);
    let flyby = spec.places.flyby;
    let mut board = Simulated::start(options.board, spec, options.seed)?;
    let stored = calibrate(&mut board, options, &mut report, &mut recorder, progress)?;
    // What was stored is all that the board knows.
    board.link.restart()?;
    if report.accepted {
        let in_force = board.link.status()?.in_force;
        if stored.map(InForce::Stored) != Some(in_force) {
            report.accepted = false;
            let wanted = "wanted the calibration that was stored";
            report.refusal = Some(format!("after the restart: found {in_force:?}, {wanted}"));
        }
    }
    let deviations = fly(&mut board, flyby, &mut recorder, progress)?;
    enter_flyby(&mut report, &deviations);
    recorder.finish()?;
    progress.finish_and_clear();
    Ok(report)
}

fn order(options: &Options) -> CalibrateOrder {
    let plan = match options.plan {
        Plan::Random => calibration::Plan::Random,
        Plan::Optimal => calibration::Plan::Optimal,
    };
    let config = SessionConfig::of_plan(plan);
    let count = |poses: u32| u16::try_from(poses).unwrap_or(u16::MAX);
    CalibrateOrder {
        method: Method::Platen,
        plan,
        poses: count(options.poses.unwrap_or(config.visits.poses)),
        held_out_poses: count(config.visits.held_out_poses),
        seed: options.seed,
        travel_m: config.visits.range.travel_m,
        turn_rad: config.visits.range.turn_rad,
        speed_m_per_s: SELF_MOTION_M_PER_S,
        target_deviation_m: config.target_deviation_m,
        commit: true,
    }
}

/// Self-motions until the session has ended, one way or the other; where the result was stored.
fn calibrate(
    board: &mut Simulated,
    options: &Options,
    report: &mut Report,
    recorder: &mut Recorder,
    progress: &ProgressBar,
) -> Result<Option<Place>> {
    progress.set_message("calibrating: poses");
    let order = order(options);
    let ended = if recorder.is_on() {
        let mut poses = StillPoses::start(board)?;
        let ended = session::run(board, &order, standstill::LOOK, progress, |board, now| {
            poses.look(board, now, recorder)
        })?;
        poses.finish(board, recorder)?;
        ended
    } else {
        session::run(board, &order, session::LOOK, progress, |_, _| Ok(()))?
    };
    let (evidence, stored, refusal) = match ended.ending {
        Some(Ending::Accepted { evidence, stored }) => (evidence, stored, None),
        Some(Ending::Refused { refusal, evidence }) => (evidence, None, Some(refusal.to_string())),
        Some(Ending::NotKept { evidence, refusal }) => (
            evidence,
            None,
            Some(format!("accepted, but not kept: {refusal}")),
        ),
        None => bail!("the session has ended without a result"),
    };
    report.poses = evidence.poses;
    report.refusal = refusal;
    report.accepted = report.refusal.is_none();
    report.held_out_residual_um =
        [evidence.held_out_raw_m, evidence.held_out_m].map(|m| 1.0e6 * f64::from(m));
    report.set("condition_number", f64::from(evidence.condition));
    let um = |length_m: f32| 1.0e6 * f64::from(length_m);
    report.set("scatter_residual_before_um", um(evidence.raw_m));
    report.set("scatter_residual_after_um", um(evidence.residual_m));
    Ok(stored)
}

/// 40 mm along y, about `middle`.
fn fly(
    board: &mut Simulated,
    middle: Pose,
    recorder: &mut Recorder,
    progress: &ProgressBar,
) -> Result<[Deviations; 2]> {
    progress.set_message("flying by");
    let geometry = linked::geometry(board)?;
    let mut flyby = Flyby::new(f64::from(geometry.pitch_m), f64::from(geometry.span_m));
    for (frame, witness) in fly_along(board, middle, FLYBY_M, FLYBY_SPEED_M_S as f32)? {
        flyby.add(&frame, &witness.reference);
        recorder.flight(&frame, &witness)?;
    }
    flyby.deviations().with_context(|| {
        format!(
            "the fly-by gave {} places, wanted 2 or more",
            flyby.places()
        )
    })
}

fn enter_flyby(report: &mut Report, [before, after]: &[Deviations; 2]) {
    for (when, deviations) in [("before", before), ("after", after)] {
        if when == "after" && !report.accepted {
            continue;
        }
        report.set(
            &format!("flyby_residual_{when}_um"),
            1.0e6 * deviations.parity_m,
        );
        report.set(
            &format!("flyby_position_{when}_um"),
            1.0e6 * deviations.position_m,
        );
        report.set(
            &format!("theta_x_{when}_mrad"),
            1.0e3 * deviations.theta_x_rad,
        );
        report.set(
            &format!("theta_y_{when}_mrad"),
            1.0e3 * deviations.theta_y_rad,
        );
    }
}
