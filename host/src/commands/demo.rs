//! `courier demo`.

use crate::board::On;
use crate::demo::joint::{JointOptions, JointReport, run as demonstrate_jointly};
use crate::demo::{Options, Plan, Preset, Report, run as demonstrate};
use crate::destination::Destination;
use crate::terminal::{figure, micrometres, print, print_json, progress, table};
use anyhow::{Result, ensure};
use courier_sensor::calibration::joint::StepReport;
use std::path::PathBuf;
use std::process::ExitCode;

/// Show the main job on a simulated courier: self-motions, calibration, restart, fly-by.
///
/// The firmware's own code boots on a simulated board (or, with --on emulated, as the board's image on an emulated Cortex-M4F) without a calibration, commands self-motions, calibrates during them
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
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

/// Demonstrates and prints.
///
/// # Errors
/// Options that make no courier, or a recording that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    if args.joint {
        return run_jointly(args);
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
        on: args.on,
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
    if args.json {
        print_json(&report)?;
    } else {
        print(&text(&report))?;
    }
    Ok(if report.accepted {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn run_jointly(args: &Args) -> Result<ExitCode> {
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
        on: args.on,
        preset: args.preset,
        seed: args.seed,
        poses: args.poses,
        platen: args.platen,
    };
    let report = demonstrate_jointly(&options, &progress(0, "starting"))?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&joint_text(&report))?;
    }
    Ok(if report.accepted {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn joint_text(report: &JointReport) -> String {
    let cell = |value: Option<f64>| value.map_or("-".to_owned(), figure);
    let rows: Vec<Vec<String>> = report
        .rows
        .iter()
        .map(|row| {
            vec![
                row.words.to_owned(),
                row.unit.to_owned(),
                figure(row.paper),
                cell(row.here),
                cell(row.paper_method),
            ]
        })
        .collect();
    let preset = format!("{:?}", report.preset).to_lowercase();
    let title = format!(
        "courier `{preset}`, seed {}: {} poses fitted under the beacon; {} synthetic problems",
        report.seed, report.poses, report.synthetic_problems
    );
    let told = |step: &StepReport| {
        format!(
            "{:?} {}",
            step.step,
            if step.accepted {
                "accepted"
            } else {
                "reverted"
            }
        )
    };
    let steps: Vec<String> = report.steps.iter().map(told).collect();
    let verdict = match &report.refusal {
        None => format!("accepted and stored: {}", steps.join(", ")),
        Some(why) => format!("REFUSED: {why}; the calibration in force before stays"),
    };
    let note = map_note(report);
    let [place_here, place_paper] = report.synthetic_place_um.map(figure);
    let place = format!(
        "synthetic, beacon's place and angle offset: {place_here} µm here, {place_paper} µm by the paper's method"
    );
    let alone = report.without_map.map_or("-".to_owned(), |flown| {
        let [x, y] = [flown.theta_x_mrad, flown.theta_y_mrad].map(figure);
        format!(
            "{} µm, θ_x {x} mrad, θ_y {y} mrad",
            figure(flown.position_um)
        )
    });
    let alone = format!("the same fly-by before the tooth map: {alone}");
    let hidden = report.theta_x_answer_uncalibrated.map_or(String::new(), |answer| {
        let answer = figure(answer);
        format!("\nbefore calibration segments 1 and 3 answer {answer} of a rotation on this line, and of teeth and lateral waves alike")
    });
    let table = table(
        &["section 3.2.1", "unit", "paper", "here", "paper's method"],
        &rows,
    );
    format!("{title}\n{verdict}\n{table}\n{place}\n{alone}{hidden}\n{note}")
}

/// What came of the tooth map.
fn map_note(report: &JointReport) -> String {
    let Some(map) = &report.map else {
        let why = report.map_refusal.as_ref().map(|why| format!(": {why}"));
        return "no tooth map".to_owned() + &why.unwrap_or_default();
    };
    let [before, after] = [map.before_m, map.after_m].map(|g| g.map(micrometres).join(", "));
    let [x, y] = map.way_deviation_m.map(micrometres);
    let [_, [theta_x, theta_y]] = map
        .way_angle_deviation_rad
        .map(|pair| pair.map(|rad| figure(1.0e3 * rad)));
    let way = format!(
        "predicted deviation of a position along x, y {x}, {y} µm, of θ_x, θ_y on a way along y {theta_x}, {theta_y} mrad"
    );
    let outside = report.outside_map.map_or(String::new(), |share| {
        format!(
            "; {} % of the fly-by outside its trusted cells",
            figure(100.0 * share)
        )
    });
    format!(
        "tooth map in force: held-out g_p, g_x, g_y {before} -> {after} µm over {} poses; {way}{outside}",
        map.held_out_poses
    )
}

fn text(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .rows
        .iter()
        .map(|row| {
            let here = row.here.map_or("-".to_owned(), figure);
            vec![
                row.words.to_owned(),
                row.unit.to_owned(),
                format!("{:.1}", row.paper),
                here,
            ]
        })
        .collect();
    let preset = format!("{:?}", report.preset).to_lowercase();
    let [before, after] = report.held_out_residual_um;
    let verdict = match &report.refusal {
        None => format!(
            "accepted: held-out g_p residual {before:.2} -> {after:.2} µm; stored, and in force after a restart"
        ),
        Some(why) => format!("REFUSED: {why}; the calibration in force before stays"),
    };
    let title = format!(
        "courier `{preset}`, seed {}: {} poses fitted",
        report.seed, report.poses
    );
    format!(
        "{title}\n{verdict}\n{}",
        table(&["section 3.1.2", "unit", "paper", "here"], &rows)
    )
}
