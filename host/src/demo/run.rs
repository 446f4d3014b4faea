//! The steps, each through the firmware on the simulated board and nothing else.

use super::flyby::{Deviations, Flyby};
use super::record::Recorder;
use super::report::Report;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use courier_sensor::app::background::{Errand, SELF_MOTION_M_PER_S};
use courier_sensor::calibration::{self, SessionConfig, Stage};
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Frame;
use courier_sensor::settings::Settings;
use effects::motion::Pose;
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::presets;
use hal_sim::spec::CourierSpec;
use hal_sim::trajectory::{FLYBY_M, FLYBY_SPEED_M_S};
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::{Witness, World};
use indicatif::ProgressBar;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Which courier is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Lateral terms and a tooth field, sized so that the paper's table comes out.
    Paper,
    /// Equation (3) and noise only.
    Ideal,
    /// Waveforms of real encoders.
    Measured,
}

/// How poses are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Plan {
    /// Uniformly, as in the paper: 1000 poses within ±0.5°.
    Random,
    /// Each to shrink the predicted deviation most: a third of the poses, within ±1.5°.
    Optimal,
}

/// What to demonstrate.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which courier.
    pub preset: Preset,
    /// Seed of the courier, its noise and its poses.
    pub seed: u64,
    /// Poses to fit; none: the plan's own number.
    pub poses: Option<u32>,
    /// How poses are chosen.
    pub plan: Plan,
    /// Table of measured waveforms for [`Preset::Measured`]; none: the project's shared data.
    pub waveforms: Option<PathBuf>,
    /// Rms of each measured waveform, m.
    pub rms_m: f64,
    /// Folder for a recording of the poses and of the fly-by.
    pub record: Option<PathBuf>,
}

/// Speed on the way to its start, m/s.
const POSITIONING_M_PER_S: f32 = SELF_MOTION_M_PER_S;
/// One flight takes 16 000 samples at 20 kHz: a motion of more than this never ends, samples.
const MOTION_LIMIT: u32 = 400_000;
/// Rest before the flight, 0.25 s at 20 kHz: the swing after a stop must not be carried into a straight line, samples.
const CALM_SAMPLES: u32 = 5000;
/// Frames of the fly-by that are kept: one in this many, 1 kHz.
const FLYBY_DECIMATION: u32 = 20;
/// Samples between two looks at the progress.
const LOOK_SAMPLES: u32 = 2000;

/// Boot, self-motions, calibration, storage, restart, fly-by.
///
/// # Errors
/// Options that make no courier, a board that does not start, a motion that never ends, a recording that cannot be written.
/// A calibration that the firmware refuses is no error: the report says so.
pub fn run(options: &Options, progress: &ProgressBar) -> Result<Report> {
    let spec = options
        .preset
        .courier(options.seed, options.waveforms.as_deref(), options.rms_m)?;
    let mut recorder = Recorder::create(options.record.as_deref(), &spec)?;
    let mut report = Report::new(options);
    let places = spec.places;
    let flash = SharedFlash::erased(options.seed);
    let world = World::new(
        spec,
        ControllerConfig::TYPICAL,
        places.scatter_corner,
        options.seed,
    )?;
    let mut board = SimBoard::start(world, flash.clone(), Settings::default())?;
    calibrate(&mut board, options, &mut report, &mut recorder, progress)?;
    // Power off and on again: what was stored is all that the board knows.
    let mut board = SimBoard::start(board.stop(), flash, Settings::default())?;
    if report.accepted
        && let Err(why) = board.background.keeper().boot()
    {
        report.accepted = false;
        report.refusal = Some(format!("after the restart: {why}"));
    }
    let deviations = fly(&mut board, places.flyby, &mut recorder, progress)?;
    enter_flyby(&mut report, &deviations);
    recorder.finish()?;
    progress.finish_and_clear();
    Ok(report)
}

impl Preset {
    /// The courier; `waveforms` and `rms_m` are for [`Preset::Measured`].
    ///
    /// # Errors
    /// A table of waveforms that cannot be used.
    pub fn courier(self, seed: u64, waveforms: Option<&Path>, rms_m: f64) -> Result<CourierSpec> {
        Ok(match self {
            Self::Paper => presets::paper(),
            Self::Ideal => presets::ideal(seed),
            Self::Measured => presets::measured(waveforms, rms_m, seed)?,
        })
    }
}

fn session(options: &Options) -> SessionConfig {
    let plan = match options.plan {
        Plan::Random => calibration::Plan::Random,
        Plan::Optimal => calibration::Plan::Optimal,
    };
    let config = SessionConfig::of_plan(plan);
    SessionConfig {
        poses: options.poses.unwrap_or(config.poses),
        seed: options.seed,
        ..config
    }
}

/// Self-motions until the session has ended, one way or the other.
fn calibrate(
    board: &mut SimBoard,
    options: &Options,
    report: &mut Report,
    recorder: &mut Recorder,
    progress: &ProgressBar,
) -> Result<()> {
    let config = session(options);
    progress.set_length(u64::from(config.poses + config.held_out_poses));
    progress.set_message("calibrating: poses");
    let fitted = config.poses;
    let errand = Errand {
        speed_m_per_s: SELF_MOTION_M_PER_S,
        commit: true,
    };
    board.background.calibrate(config, errand)?;
    let mut last = (Stage::Origin, 0);
    for sample in 0_u32.. {
        let frame = board.sample();
        let now = board.background.progress();
        if (now.stage, now.done) != last {
            last = (now.stage, now.done);
            recorder.pose(board, &frame)?;
        }
        if sample.is_multiple_of(LOOK_SAMPLES) {
            let before = if now.stage == Stage::HeldOut {
                fitted
            } else {
                0
            };
            progress.set_position(u64::from(before + now.done));
        }
        if board.background.ended().is_some() {
            break;
        }
    }
    let ended = board
        .background
        .ended()
        .context("the session has ended without a result")?;
    let evidence = &ended.evidence;
    report.poses = evidence.poses;
    report.refusal = match (&ended.result, &ended.not_kept) {
        (Err(refusal), _) => Some(refusal.to_string()),
        (Ok(_), Some(why)) => Some(format!("accepted, but not kept: {why}")),
        (Ok(_), None) => None,
    };
    report.accepted = report.refusal.is_none();
    report.held_out_residual_um =
        [evidence.held_out_raw_m, evidence.held_out_m].map(|m| 1.0e6 * f64::from(m));
    report.set("condition_number", f64::from(evidence.condition));
    report.set(
        "scatter_residual_before_um",
        1.0e6 * f64::from(evidence.raw_m),
    );
    report.set(
        "scatter_residual_after_um",
        1.0e6 * f64::from(evidence.residual_m),
    );
    Ok(())
}

/// 40 mm along y, about `middle`.
fn fly(
    board: &mut SimBoard,
    middle: Pose,
    recorder: &mut Recorder,
    progress: &ProgressBar,
) -> Result<[Deviations; 2]> {
    progress.set_message("flying by");
    let geometry = board.background.keeper().settings().geometry;
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

/// A straight flight along y over `length_m` about `middle`: frames at 1 kHz, and what the interferometer read at each.
///
/// # Errors
/// A motion that never ends.
pub(super) fn fly_along(
    board: &mut SimBoard,
    middle: Pose,
    length_m: f64,
    speed_m_per_s: f32,
) -> Result<Vec<(Frame, Witness)>> {
    let end = line_up(board, middle, 0.5 * length_m)?;
    let start = line_up(board, middle, -0.5 * length_m)?;
    go(board, start, POSITIONING_M_PER_S, |_, _| ())?;
    (0..CALM_SAMPLES).for_each(|_| {
        board.sample();
    });
    board.world.watch();
    let mut frames: Vec<(u64, Frame)> = Vec::new();
    go(board, end, speed_m_per_s, |board, frame| {
        if frame.sequence.is_multiple_of(FLYBY_DECIMATION) {
            frames.push((board.conversion_of(frame), *frame));
        }
    })?;
    let (first, witnesses) = board.world.unwatch();
    let of = |(conversion, frame): (u64, Frame)| {
        let index = usize::try_from(conversion.saturating_sub(first))?;
        let witness = witnesses
            .get(index)
            .context("a frame without its conversion")?;
        Ok((frame, *witness))
    };
    frames.into_iter().map(of).collect()
}

/// Goes to a pose and waits there.
///
/// # Errors
/// A motion that never ends.
pub(super) fn stand_at(board: &mut SimBoard, pose: Pose) -> Result<()> {
    let goal = Target {
        x_m: pose.x_m as f32,
        y_m: pose.y_m as f32,
        theta_rad: pose.theta_rad as f32,
    };
    go(board, goal, POSITIONING_M_PER_S, |_, _| ())?;
    (0..CALM_SAMPLES).for_each(|_| {
        board.sample();
    });
    Ok(())
}

/// The command that brings the courier to `along_m` on the line through `middle`. The controller is open loop and tens of
/// micrometres off; the phase of the platen sensor tells by how much, and angle alike.
fn line_up(board: &mut SimBoard, middle: Pose, along_m: f64) -> Result<Target> {
    let pitch_m = f64::from(board.background.keeper().settings().geometry.pitch_m);
    let mut goal = Target {
        x_m: middle.x_m as f32,
        y_m: (middle.y_m + along_m) as f32,
        theta_rad: middle.theta_rad as f32,
    };
    go(board, goal, POSITIONING_M_PER_S, |_, _| ())?;
    let pose = board.background.last_frame().pose;
    let off_turns = f64::from(pose.x.fraction_turns) - middle.x_m / pitch_m;
    goal.x_m -= ((off_turns - off_turns.round()) * pitch_m) as f32;
    goal.theta_rad -= pose.theta_rad - middle.theta_rad as f32;
    Ok(goal)
}

/// Moves and waits until the controller says that it has settled; `watch` sees every frame.
fn go(
    board: &mut SimBoard,
    goal: Target,
    speed_m_per_s: f32,
    mut watch: impl FnMut(&SimBoard, &Frame),
) -> Result<()> {
    board.background.go_to(goal, speed_m_per_s)?;
    for _ in 0..MOTION_LIMIT {
        let frame = board.sample();
        watch(board, &frame);
        if !board.background.is_moving() {
            return Ok(());
        }
    }
    bail!("the motion controller has not settled after {MOTION_LIMIT} samples")
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
