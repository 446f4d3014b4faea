//! `courier calibrate`.

use super::calibrate_guided::Guide;
use super::calibrate_joint::{Found, steps_table};
use super::calibrate_text;
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::session::{self, LOOK};
use crate::board::{Choice, Link, geometry, motion};
use crate::terminal::{print, progress, warn};
use crate::witness::Witness;
use anyhow::{Result, bail};
use clap::ValueEnum;
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::calibration::joint::JointConfig;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::{self, SessionConfig, Stage};
use courier_sensor::drivers::motion::Target;
use courier_sensor::link::message::{Action, CalibrateOrder, Reply, Source};
use courier_sensor::link::{JOINT_POSES, LEAST_JOINT_POSES, LEAST_PLATEN_POSES, PLATEN_POSES};
use courier_sensor::link::report::{Ending, Progress};
use serde::Serialize;
use std::process::ExitCode;

/// How poses are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Plan {
    /// Uniformly, as in the paper.
    Random,
    /// Each to shrink the predicted deviation most.
    Optimal,
}

/// Let a board calibrate itself by self-motions, and wait for the result.
///
/// The board decides by poses that it did not fit whether it takes the result, stores it, and says why if not. Exit code 1
/// if it was refused; the calibration in force then stays. Meanwhile the segments' readings are held against each other: exchanged
/// wires or a wrong pitch end the session, with what would be right.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin calibrate --plan optimal")]
pub struct Args {
    /// How poses are chosen.
    #[arg(long, value_enum, default_value_t = Plan::Random)]
    plan: Plan,
    /// Poses to fit at most.
    #[arg(long, help = poses_help())]
    poses: Option<u16>,
    /// Poses held out for the test, 8 to 1000.
    #[arg(long, default_value_t = 200)]
    held_out: u16,
    /// Poses are drawn from this seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Poses lie within so much of the start, mm, from one pitch to 500 (to 100 if joint) [default: 10.16, or 2.032 if joint].
    #[arg(long, value_name = "MM")]
    travel_mm: Option<f32>,
    /// Largest angle, degrees [default: 0.5, or 1.5 if optimal or joint].
    #[arg(long, value_name = "DEG")]
    turn_deg: Option<f32>,
    /// Stop when the worst predicted deviation is below this, µm; 0: use all poses.
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "UM",
        conflicts_with = "joint"
    )]
    target_um: f32,
    /// Both sensors together, under a beacon: the platen sensor, then the coordination sensor's place, then all.
    #[arg(long)]
    joint: bool,
    /// Tell before the first pose what this motion determines and how well, move to as many chosen poses as that takes and no more, and
    /// tell what is determined meanwhile. Wanted is --target-um, or 0.2 µm.
    #[arg(long, conflicts_with = "plan")]
    guided: bool,
    /// Go there first: mm, mm and degrees in the motion controller's frame [default for a simulated courier with --joint:
    /// under its beacon].
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target)]
    from: Option<Target>,
    /// Put the result in force, but do not store it.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier calibrate`", &["ending"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// Deviation that a guided calibration wants unless told otherwise, µm: the sensor's resolution (the paper, section 1).
const GUIDED_UM: f32 = 0.2;
/// Largest angle of a planned motion, 1.5 degrees.
const OPTIMAL_TURN_RAD: f32 = 0.026_18;

/// What `--json` prints.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    progress: &'a Progress,
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<Found>,
    #[serde(skip_serializing_if = "Option::is_none")]
    guided: Option<Guide>,
}

/// Orders, waits, prints.
///
/// # Errors
/// The board cannot be reached, does not start, or its readings cannot be right.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut order = order(args);
    let mut board = choice.open()?;
    let mut guide = args.guide(&mut order, &mut board.link)?;
    if let Some(guide) = guide.as_ref().filter(|_| !args.json.is_printed()) {
        print(&guide.plan())?;
    }
    let start = args.from.or(if args.joint { board.beacon } else { None });
    if let Some(target) = start {
        motion::go(&mut board.link, target, SELF_MOTION_M_PER_S)?;
    }
    let mapped = board.link.status()?.map.is_some();
    let (progress, plausible) = wait(&mut board.link, &order, &mut guide, args.json.is_printed())?;
    if mapped && board.link.status()?.map.is_none() {
        warn(
            "the tooth map is out of force: it belongs to the calibration before; map again, or load that one",
        );
    }
    let found = match progress.ending {
        Some(Ending::Accepted { .. }) if args.joint => Some(found(&mut board.link)?),
        _ => None,
    };
    board.close()?;
    let Some(ending) = &progress.ending else {
        bail!("the board: found a session without an ending, wanted a result")
    };
    if let Ending::Accepted { evidence, .. } = ending
        && let Some(missed) = calibrate_text::missed_target(evidence, order.target_deviation_m)
    {
        warn(&missed);
    }
    let told = Told {
        progress: &progress,
        found,
        guided: guide,
    };
    args.json.tell(ANSWER, &told, || {
        let mut parts = Vec::new();
        if args.joint {
            parts.push(steps_table(&progress));
            parts.extend(told.found.as_ref().map(Found::text));
        }
        parts.push(told_ending(ending));
        parts.join("\n")
    })?;
    Ok(match ending {
        Ending::Accepted { .. } if plausible => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

impl Args {
    /// With --guided: as many poses as are needed.
    fn guide(&self, order: &mut CalibrateOrder, link: &mut Link) -> Result<Option<Guide>> {
        if !self.guided {
            return Ok(None);
        }
        let wanted_um = if self.target_um > 0.0 { self.target_um } else { GUIDED_UM };
        let least = if self.joint { LEAST_JOINT_POSES } else { LEAST_PLATEN_POSES };
        let guide = Guide::new(order, geometry::in_force(link), 1.0e-6 * f64::from(wanted_um), least)?;
        order.poses = guide.poses();
        // The poses are counted out: the board's own limit is for those that are not.
        order.target_deviation_m = 0.0;
        Ok(Some(guide))
    }
}

/// How it ended, in a sentence.
fn told_ending(ending: &Ending) -> String {
    match ending {
        Ending::Accepted {
            evidence, stored, ..
        } => {
            let place = stored.map_or("not stored".to_owned(), |place| {
                format!("stored in slot {}, number {}", place.slot, place.sequence)
            });
            let mut lines = vec![format!("accepted: {}; {place}", calibrate_text::evidence(evidence))];
            lines.extend(calibrate_text::worth(evidence));
            lines.join("\n")
        }
        Ending::Refused { refusal, evidence } => format!(
            "refused: {refusal}; {}; the calibration in force before stays",
            calibrate_text::evidence(evidence)
        ),
        Ending::NotKept { refusal, evidence } => format!(
            "accepted, but not kept: {refusal}; {}; the calibration in force before stays",
            calibrate_text::evidence(evidence)
        ),
    }
}

fn order(args: &Args) -> CalibrateOrder {
    let paper = if args.joint {
        JointConfig::default().visits.range
    } else {
        SessionConfig::default().visits.range
    };
    let named = if args.guided { Plan::Optimal } else { args.plan };
    let (plan, poses, turn_rad) = match named {
        Plan::Random => (calibration::Plan::Random, 1000, paper.turn_rad),
        Plan::Optimal => (calibration::Plan::Optimal, 333, OPTIMAL_TURN_RAD),
    };
    CalibrateOrder {
        method: if args.joint {
            Method::Joint
        } else {
            Method::Platen
        },
        plan,
        poses: args.poses.unwrap_or(poses),
        held_out_poses: args.held_out,
        seed: args.seed,
        travel_m: args
            .travel_mm
            .map_or(paper.travel_m, |travel_mm| travel_mm * 1.0e-3),
        turn_rad: args.turn_deg.map_or(turn_rad, f32::to_radians),
        target_deviation_m: args.target_um * 1.0e-6,
        commit: !args.dry_run,
        ..CalibrateOrder::default()
    }
}

/// The joint calibration that was just put in force.
fn found(link: &mut Link) -> Result<Found> {
    let Reply::Calibration(calibration) = link.ask(Action::Read(Source::InForce))? else {
        bail!(super::STRANGE_REPLY)
    };
    Ok(Found::new(&calibration))
}

/// How the session ended, and whether its readings can be right.
fn wait(
    link: &mut Link,
    order: &CalibrateOrder,
    guide: &mut Option<Guide>,
    quiet: bool,
) -> Result<(Progress, bool)> {
    let bar = progress(0, "calibrating: poses");
    let mut witness = Witness::start(link)?;
    let ended = session::run(link, order, LOOK, &bar, |link, now| {
        let done = match now.stage {
            Stage::Origin => 0,
            Stage::Fit => now.done,
            Stage::HeldOut | Stage::Solving | Stage::Finished => order.poses.into(),
        };
        let lines = guide.iter_mut().flat_map(|guide| guide.look(done));
        let lines: Vec<String> = lines.collect();
        if !lines.is_empty() && !quiet {
            bar.suspend(|| print(&lines.join("\n")))?;
        }
        witness.look(link, now)
    });
    bar.finish_and_clear();
    Ok((ended?, witness.end(link)?))
}

/// The least and the most number of poses, as the board checks it.
fn poses_help() -> String {
    format!(
        "Poses to fit at most, {LEAST_PLATEN_POSES} to {PLATEN_POSES} ({LEAST_JOINT_POSES} to {JOINT_POSES} if joint) [default: 1000, or 333 if optimal]"
    )
}
