//! `courier demo`.

use crate::demo::{Options, Plan, Preset, Report, run as demonstrate};
use crate::terminal::{figure, print, print_json, progress, table};
use anyhow::{Result, ensure};
use std::path::PathBuf;
use std::process::ExitCode;

/// Show the main job on a simulated courier: self-motions, calibration, restart, fly-by.
///
/// The firmware's own code boots on a simulated board without a calibration, commands self-motions, calibrates during them
/// by incremental QR, accepts the result by its own tests, stores it, restarts from what it stored and flies by 40 mm. The
/// table is the paper's section 3.1.2 with the figures found here beside it. Exit code 1 if the calibration was refused.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier demo --preset measured --plan optimal --seed 7")]
pub struct Args {
    /// Which courier is simulated.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Seed of the courier, its noise and its poses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Poses to fit, 40 to 20000 [default: 1000, or 333 if optimal].
    #[arg(long, value_parser = clap::value_parser!(u32).range(40..=20_000))]
    poses: Option<u32>,
    /// How poses are chosen.
    #[arg(long, value_enum, default_value_t = Plan::Random)]
    plan: Plan,
    /// Table of measured waveforms for the preset `measured`, a column an encoder.
    #[arg(long, value_name = "FILE")]
    waveforms: Option<PathBuf>,
    /// Rms of each measured waveform, µm [default: 10].
    #[arg(long, value_name = "UM")]
    rms_um: Option<f64>,
    /// Write the poses and the fly-by as a recording into this folder.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

/// Demonstrates and prints.
///
/// # Errors
/// Options that make no courier, or a recording that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let measured = args.preset == Preset::Measured;
    ensure!(measured || args.waveforms.is_none(), "--waveforms: found preset {:?}, wanted --preset measured", args.preset);
    ensure!(measured || args.rms_um.is_none(), "--rms-um: found preset {:?}, wanted --preset measured", args.preset);
    let options = Options {
        preset: args.preset,
        seed: args.seed,
        poses: args.poses,
        plan: args.plan,
        waveforms: args.waveforms.clone(),
        rms_m: args.rms_um.map_or(hal_sim::presets::DEFAULT_RMS_M, |rms_um| rms_um * 1.0e-6),
        record: args.record.clone(),
    };
    let report = demonstrate(&options, &progress(0, "starting"))?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&text(&report))?;
    }
    Ok(if report.accepted { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .rows
        .iter()
        .map(|row| {
            let here = row.here.map_or("-".to_owned(), figure);
            vec![row.words.to_owned(), row.unit.to_owned(), format!("{:.1}", row.paper), here]
        })
        .collect();
    let preset = format!("{:?}", report.preset).to_lowercase();
    let [before, after] = report.held_out_residual_um;
    let verdict = match &report.refusal {
        None => format!("accepted: held-out g_p residual {before:.2} -> {after:.2} µm; stored, and in force after a restart"),
        Some(why) => format!("REFUSED: {why}; the calibration in force before stays"),
    };
    let title = format!("courier `{preset}`, seed {}: {} poses fitted", report.seed, report.poses);
    format!("{title}\n{verdict}\n{}", table(&["section 3.1.2", "unit", "paper", "here"], &rows))
}
