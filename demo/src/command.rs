//! `cargo demo` and `courier demo`: options, and what is printed.

use crate::joint::{JointOptions, run as demonstrate_jointly};
use crate::text::{joint_text, text};
use crate::{Options, Plan, Preset, run as demonstrate};
use anyhow::{Result, ensure};
use board_link::Starter;
use command_line::destination::Destination;
use command_line::json::Json;
use command_line::output::{Files, Kind};
use command_line::terminal::progress;
use std::path::PathBuf;
use std::process::ExitCode;

/// What the firmware runs on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum On {
    /// This process: the firmware's own code, built for this machine.
    #[default]
    Sim,
    /// An emulated Cortex-M4F: the firmware's image in QEMU.
    Emulated,
    /// The sensor board's image as it ships, on a model of its chip; a second takes 3 to 5.
    Chip,
}

/// Show the main job on a simulated courier: self-motions, calibration, restart, fly-by.
///
/// The firmware's own code boots on a simulated board (or, with --on emulated, as the board's image on an emulated Cortex-M4F, or with --on chip, as the image that ships on a model of its chip) without a calibration, commands self-motions, calibrates during them
/// by incremental QR, accepts the result by its own tests, stores it, restarts from what it stored and flies by 40 mm. The
/// table is the paper's section 3.1.2 with the figures found here beside it. Exit code 1 if the calibration was refused.
///
/// With --joint it is section 3.2.1: the paper's synthetic problem; then one courier through platen calibration, joint
/// calibration under a beacon and the 8 mm fly-by there. Beside the figures of this system's method stand those of the paper's
/// method (equal weights, no terms of the coordination sensor's own) on poses of the paper's range, two pitches; this
/// system's poses cover the fly-by.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier demo --preset measured --plan optimal --seed 7\n  courier demo --on emulated --poses 200\n  courier demo --joint\n  courier demo --joint --on emulated --poses 100"
)]
pub struct Args {
    /// The joint calibration of both sensors, section 3.2.1.
    #[arg(long, conflicts_with_all = ["plan", "waveforms", "rms_um", "record"])]
    joint: bool,
    /// What the firmware runs on; what is missing for the emulated board is built first.
    #[arg(long, value_enum, value_name = "BOARD", default_value_t = On::Sim)]
    on: On,
    /// Which courier is simulated.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Seed of the courier, its noise and its poses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Poses to fit, 40 to 20000 (50 to 1000 with --joint) [default: 1000, or 333 if optimal].
    #[arg(long, value_parser = clap::value_parser!(u32).range(40..=20_000))]
    poses: Option<u32>,
    /// How poses are chosen.
    #[arg(long, value_enum, default_value_t = Plan::Random)]
    plan: Plan,
    /// With --joint and the preset `paper`: the same courier on another platen of the same make, drawn by this seed.
    #[arg(long, value_name = "SEED", requires = "joint")]
    platen: Option<u64>,
    /// Table of measured waveforms for the preset `measured`, a column an encoder.
    #[arg(long, value_name = "FILE")]
    waveforms: Option<PathBuf>,
    /// Rms of each measured waveform, µm [default: 10].
    #[arg(long, value_name = "UM")]
    rms_um: Option<f64>,
    /// Write the poses and the fly-by as a recording into this folder.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Replace the recording in that folder.
    #[arg(long, requires = "record")]
    force: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("a report of `courier demo`", &["rows", "accepted"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let mut files = Files::default();
        if let Some(path) = &self.waveforms {
            files = files.reads(path);
        }
        if let Some(folder) = &self.record {
            files = files.fills(folder);
        }
        files.json(&self.json, ANSWER)
    }

    /// What `--on` names.
    pub fn on(&self) -> On {
        self.on
    }
}

/// Demonstrates on a board that `board` starts, and prints.
///
/// # Errors
/// Options that make no courier, or a recording that cannot be written.
pub fn demo(args: &Args, board: Starter) -> Result<ExitCode> {
    if args.joint {
        return run_jointly(args, board);
    }
    let measured = args.preset == Preset::Measured;
    ensure!(
        measured || args.waveforms.is_none(),
        "--waveforms: found preset {:?}, wanted --preset measured",
        args.preset
    );
    ensure!(
        measured || args.rms_um.is_none(),
        "--rms-um: found preset {:?}, wanted --preset measured",
        args.preset
    );
    let options = Options {
        board,
        preset: args.preset,
        seed: args.seed,
        poses: args.poses,
        plan: args.plan,
        waveforms: args.waveforms.clone(),
        rms_m: args
            .rms_um
            .map_or(hal_sim::presets::DEFAULT_RMS_M, |rms_um| rms_um * 1.0e-6),
        record: args.record.clone().map(|folder| Destination {
            folder,
            force: args.force,
        }),
    };
    let report = demonstrate(&options, &progress(0, "starting"))?;
    args.json.tell(ANSWER, &report, || text(&report))?;
    Ok(if report.accepted {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn run_jointly(args: &Args, board: Starter) -> Result<ExitCode> {
    if let Some(poses) = args.poses {
        ensure!(
            (50..=1000).contains(&poses),
            "--poses: found {poses}, wanted 50 to 1000 with --joint"
        );
    }
    let papers = args.preset == Preset::Paper || args.platen.is_none();
    ensure!(
        papers,
        "--platen: found preset {:?}, wanted --preset paper",
        args.preset
    );
    let options = JointOptions {
        board,
        preset: args.preset,
        seed: args.seed,
        poses: args.poses,
        platen: args.platen,
    };
    let report = demonstrate_jointly(&options, &progress(0, "starting"))?;
    args.json.tell(ANSWER, &report, || joint_text(&report))?;
    Ok(if report.accepted {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
