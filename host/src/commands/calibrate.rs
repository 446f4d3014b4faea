//! `courier calibrate`.

use crate::board::{Choice, Link};
use crate::terminal::{figure, print, print_json, progress};
use anyhow::{Result, bail};
use clap::ValueEnum;
use courier_sensor::calibration::{self, Evidence, Stage};
use courier_sensor::link::message::{Action, CalibrateOrder, Reply};
use courier_sensor::link::report::{Ending, Progress};
use std::process::ExitCode;
use std::time::Duration;

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
/// if it was refused; the calibration in force then stays.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin calibrate --plan optimal")]
pub struct Args {
    /// How poses are chosen.
    #[arg(long, value_enum, default_value_t = Plan::Random)]
    plan: Plan,
    /// Poses to fit at most, 50 to 10000 [default: 1000, or 333 if optimal].
    #[arg(long)]
    poses: Option<u16>,
    /// Poses held out for the test, 8 to 1000.
    #[arg(long, default_value_t = 200)]
    held_out: u16,
    /// Poses are drawn from this seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Poses lie within so much of the start, mm, 1 to 500.
    #[arg(long, default_value_t = 10.16, value_name = "MM")]
    travel_mm: f32,
    /// Largest angle, degrees [default: 0.5, or 1.5 if optimal].
    #[arg(long, value_name = "DEG")]
    turn_deg: Option<f32>,
    /// Stop when the worst predicted deviation is below this, µm; 0: use all poses.
    #[arg(long, default_value_t = 0.0, value_name = "UM")]
    target_um: f32,
    /// Put the result in force, but do not store it.
    #[arg(long)]
    dry_run: bool,
    /// Print one JSON object instead of sentences.
    #[arg(long)]
    json: bool,
}

/// Time between two looks at the progress, of the board's own.
const LOOK: Duration = Duration::from_millis(50);

/// Orders, waits, prints.
///
/// # Errors
/// The board cannot be reached, or does not start.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let progress = wait(&mut board.link, &order(args))?;
    board.close()?;
    if args.json {
        print_json(&progress)?;
    }
    match &progress.ending {
        Some(Ending::Accepted { evidence, stored, .. }) => {
            if !args.json {
                let place = stored.map_or("not stored".to_owned(), |place| format!("stored in slot {}, number {}", place.slot, place.sequence));
                print(&format!("accepted: {}; {place}", sentence(evidence)))?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Some(Ending::Refused { refusal, evidence }) => {
            if !args.json {
                print(&format!("refused: {refusal}; {}; the calibration in force before stays", sentence(evidence)))?;
            }
            Ok(ExitCode::FAILURE)
        }
        Some(Ending::NotKept { refusal, evidence }) => {
            if !args.json {
                print(&format!("accepted, but not kept: {refusal}; {}; the calibration in force before stays", sentence(evidence)))?;
            }
            Ok(ExitCode::FAILURE)
        }
        None => bail!("the board: found a session without an ending, wanted a result"),
    }
}

fn order(args: &Args) -> CalibrateOrder {
    let (plan, poses, turn_deg) = match args.plan {
        Plan::Random => (calibration::Plan::Random, 1000, 0.5_f32),
        Plan::Optimal => (calibration::Plan::Optimal, 333, 1.5),
    };
    CalibrateOrder {
        plan,
        poses: args.poses.unwrap_or(poses),
        held_out_poses: args.held_out,
        seed: args.seed,
        travel_m: args.travel_mm * 1.0e-3,
        turn_rad: args.turn_deg.unwrap_or(turn_deg).to_radians(),
        target_deviation_m: args.target_um * 1.0e-6,
        commit: !args.dry_run,
        ..CalibrateOrder::default()
    }
}

fn wait(link: &mut Link, order: &CalibrateOrder) -> Result<Progress> {
    let Reply::Done = link.ask(Action::Calibrate(*order))? else { bail!(super::STRANGE_REPLY) };
    let bar = progress(u64::from(order.poses) + u64::from(order.held_out_poses), "calibrating: poses");
    loop {
        link.pass(LOOK)?;
        let Reply::Progress(now) = link.ask(Action::Progress)? else { bail!(super::STRANGE_REPLY) };
        let before = if now.stage == Stage::HeldOut { u64::from(order.poses) } else { 0 };
        bar.set_position(before + u64::from(now.done));
        if now.ending.is_some() {
            bar.finish_and_clear();
            return Ok(now);
        }
    }
}

fn sentence(evidence: &Evidence) -> String {
    let um = |length_m: f32| figure(1.0e6 * f64::from(length_m));
    format!(
        "{} poses, condition number {:.1}, rank {} of {}, held-out g_p residual {} -> {} µm",
        evidence.poses,
        evidence.condition,
        evidence.rank,
        evidence.unknowns,
        um(evidence.held_out_in_force_m),
        um(evidence.held_out_m)
    )
}
