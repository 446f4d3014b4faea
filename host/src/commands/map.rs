//! `courier map RECORDING`.

use crate::findings::{self, BOTH_SENSORS};
use crate::json::Json;
use crate::kinds;
use crate::output::{self, Files, Kind};
use crate::recordings;
use crate::teeth::{Evidence, MapFile, Mapped, TeethPose, estimate, poses_of};
use crate::terminal::{figure, micrometres, pairs, progress, warn};
use anyhow::{Result, ensure};
use courier_sensor::frame::SEGMENTS;
use std::path::PathBuf;
use std::process::ExitCode;

/// Poses of a usual map, as the joint calibration under a beacon makes them.
const LEAST_POSES: u32 = 1000;
/// Passes of a usual fit, for the progress bar.
const PASSES: u64 = 24;

/// Estimate a map of the platen's teeth from a recording under a beacon.
///
/// The recording holds all four segments and the coordination sensor, over the area to be mapped and with rotation (±1.5° or so):
/// 1000 still poses, or the sweeps of `courier record --under-beacon`. The map holds how far the teeth are displaced along x and y, where poses have told it, and lateral
/// waves of mixed order; `courier load FILE` stores it in a board, which places it by its beacon at each start.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, on the simulated courier and its own beacon:\n  courier --sim-flash board.bin calibrate\n  courier --sim-flash board.bin record beacon --under-beacon\n  courier map beacon --out teeth.json\n  courier --sim-flash board.bin load teeth.json"
)]
pub struct Args {
    /// The recording's folder.
    recording: PathBuf,
    /// Where to write the map, JSON; without it, only what it is worth is told.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite the file.
    #[arg(long)]
    force: bool,
    /// Take poses within so much of the median place only, mm: a smaller map.
    #[arg(long, value_name = "MM")]
    within: Option<f64>,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("what a tooth map is worth", &["poses", "unknowns"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().reads_recording(&self.recording).writes_new(self.out.as_ref(), kinds::MAP, self.force).json(&self.json, ANSWER)
    }
}

/// Reads, estimates, writes.
///
/// # Errors
/// The recording cannot be read or does not tell a map, or the file cannot be written; nothing is written then.
pub fn run(args: &Args) -> Result<ExitCode> {
    let within_mm = args.within.unwrap_or(f64::INFINITY);
    ensure!(
        within_mm > 0.0,
        "--within: found {within_mm}, wanted above 0"
    );
    let recording = recordings::read(&args.recording)?;
    recording.warnings.iter().for_each(|line| warn(line));
    findings::check(&recording, &args.recording.display().to_string(), BOTH_SENSORS)?;
    let (setup, mut poses) = poses_of(&recording)?;
    near_middle(&mut poses, 1.0e-3 * within_mm);
    let bar = progress(PASSES, "fitting");
    let mapped = estimate(&setup, &poses, &mut || bar.inc(1));
    bar.finish_and_clear();
    let file = MapFile::new(mapped?);
    ensure!(
        trusted_cells(&file.map) > 0,
        "{}: found no cell whose teeth are known well enough to be applied, wanted more poses of the area: {LEAST_POSES} or more, turned by ±1.5°",
        args.recording.display()
    );
    if let Some(path) = &args.out {
        let text = serde_json::to_string_pretty(&file)?;
        output::write(path, kinds::MAP, text.as_bytes())?;
    }
    args.json
        .tell(ANSWER, &file.map.evidence, || text(&file.map))?;
    Ok(ExitCode::SUCCESS)
}

/// Keeps poses whose outputs are all near their medians.
fn near_middle(poses: &mut Vec<TeethPose>, within_m: f64) {
    let medians: [f64; SEGMENTS] = std::array::from_fn(|i| {
        let mut values: Vec<f64> = poses.iter().map(|pose| pose.outputs_m[i]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or_default()
    });
    poses.retain(|pose| (0..SEGMENTS).all(|i| (pose.outputs_m[i] - medians[i]).abs() <= within_m));
}

/// Cells that a board would apply.
fn trusted_cells(map: &Mapped) -> u32 {
    let words = map.header.trusted.iter();
    words.map(|word| word.count_ones()).sum()
}

fn text(map: &Mapped) -> String {
    let Evidence {
        poses,
        held_out_poses,
        unknowns,
        before_m,
        after_m,
        ..
    } = map.evidence;
    let evidence = &map.evidence;
    let three = |g: [f64; 3]| g.map(micrometres).join(", ");
    let size = |k: usize| {
        let [along, across] = map.header.grids[k].nodes;
        // None trusted: no deviation is the worst.
        let worst_m = evidence.worst_deviation_m[k];
        let known = if worst_m > 0.0 {
            format!(
                "trusted cells known to {} µm or better",
                micrometres(worst_m)
            )
        } else {
            "no trusted cell".to_owned()
        };
        format!("{along} by {across} nodes, {known}")
    };
    let trusted = trusted_cells(map);
    let angles = evidence.way_angle_deviation_rad.as_flattened();
    let angles: Vec<String> = angles.iter().map(|rad| figure(1.0e3 * rad)).collect();
    pairs(&[
        (
            "poses",
            format!("{poses} fitted, {held_out_poses} held out, {unknowns} unknowns"),
        ),
        (
            "held-out g_p, g_x, g_y",
            format!(
                "{} -> {} µm, {:.0} standard errors",
                three(before_m),
                three(after_m),
                evidence.significance
            ),
        ),
        (
            "noise shown",
            format!(
                "segment {} µm, displacement {} µm",
                micrometres(evidence.segment_noise_m),
                micrometres(evidence.displacement_noise_m)
            ),
        ),
        (
            "a position along x, y",
            format!(
                "predicted to {} µm",
                evidence.way_deviation_m.map(micrometres).join(", ")
            ),
        ),
        (
            "angles on those ways",
            format!(
                "predicted to {} mrad, by segments 1 and 3, 2 and 4",
                angles.join(", ")
            ),
        ),
        ("field along x", size(0)),
        ("field along y", size(1)),
        ("trusted cells", format!("{trusted} of both fields")),
        (
            "gauge",
            "each field's mean is zero; its slope (a scale) is the one that displaces teeth least"
                .to_owned(),
        ),
    ])
}
