//! `courier replay RECORDING`.

use crate::findings::{self, SEGMENTS_AND_REFERENCE};
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::recordings;
use crate::calibration_file::CalibrationFile;
use crate::replay::{Applied, HeldOut, Remark, Report, applied, remarks, replay};
use crate::terminal::{micrometres, progress, table, warn};
use anyhow::Result;
use indicatif::ProgressBar;
use plausibility::Finding;
use recording::Recording;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Calibrate on a recording and show what remains on stretches that were not fitted.
///
/// The firmware's own signal path and incremental least squares run over the recording: one segment against a
/// reference, or four segments against each other (g_p, equation 5). A third of the motion, in contiguous blocks of both
/// directions of travel, is held out. What remains is remarked on where it cannot be a sensor's error, or where calibration takes
/// nothing away; exit code 1 where it is of the size of the pitch. Segments or a reference whose wires, units or pitch cannot be right are
/// refused, with what would be right.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier replay examples/survey-lateral")]
pub struct Args {
    /// The recording: a folder with recording.toml and samples.csv, or a .parquet or .mcap file.
    recording: PathBuf,
    /// Fit nothing: apply this calibration, as `courier export` wrote it, and show g_p over the whole recording.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("a replay", &["recording", "held_out", "channels"]);

/// The same with `--calibration`.
const APPLIED: Kind = Kind::json("a replay of a calibration", &["recording", "calibration", "g_p"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default().reads_recording(&self.recording);
        match &self.calibration {
            Some(path) => files.reads(path).json(&self.json, APPLIED),
            None => files.json(&self.json, ANSWER),
        }
    }
}

/// What `--json` prints of what was fitted.
#[derive(Serialize)]
struct Fitted {
    recording: String,
    #[serde(flatten)]
    report: Report,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    remarks: Vec<Remark>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    findings: Vec<Finding>,
}

/// What `--json` prints of what was applied, keys in the order of the alphabet.
#[derive(Serialize)]
struct OfCalibration {
    calibration: String,
    findings: Vec<Finding>,
    g_p: Applied,
    recording: String,
    remarks: Vec<Remark>,
}

/// Either, as it is printed.
#[derive(Serialize)]
#[serde(untagged)]
enum Figures {
    Fitted(Fitted),
    OfCalibration(OfCalibration),
}

/// What a replay tells.
#[derive(Serialize)]
#[serde(transparent)]
pub struct Answer {
    figures: Figures,
    /// In words.
    #[serde(skip)]
    pub text: String,
}

impl Answer {
    /// What looks wrong about the figures.
    #[must_use]
    pub fn remarks(&self) -> &[Remark] {
        match &self.figures {
            Figures::Fitted(figures) => &figures.remarks,
            Figures::OfCalibration(figures) => &figures.remarks,
        }
    }
}

/// Reads, calibrates, prints.
///
/// # Errors
/// A bad recording, one whose segments or reference cannot be as they are stated, or one that cannot be calibrated on.
pub fn run(args: &Args) -> Result<ExitCode> {
    let recording = recordings::read(&args.recording)?;
    recording.warnings.iter().for_each(|warning| warn(warning));
    let answer = answer(args, &recording, &progress(0, "replaying"), &mut warn)?;
    let kind = if args.calibration.is_some() { APPLIED } else { ANSWER };
    args.json.tell(kind, &answer, || answer.text.clone())?;
    Ok(warned(answer.remarks()))
}

/// The figures of a recording, as the options say. What is wrong in what is not used goes to `tell`.
///
/// # Errors
/// As [`run`].
pub fn answer(
    args: &Args,
    recording: &Recording,
    bar: &ProgressBar,
    tell: &mut dyn FnMut(&str),
) -> Result<Answer> {
    let place = args.recording.display().to_string();
    let findings = findings::check_telling(recording, &place, SEGMENTS_AND_REFERENCE, tell)?;
    match recording.samples.missed_instants() {
        0 => {}
        missed => tell(&format!(
            "samples.csv: {missed} sampling instants have no row: each row stands at its own time, and time goes on between them"
        )),
    }
    match &args.calibration {
        Some(path) => apply(recording, place, path, findings),
        None => fit(recording, place, findings, bar),
    }
}

fn fit(
    recording: &Recording,
    place: String,
    findings: Vec<Finding>,
    bar: &ProgressBar,
) -> Result<Answer> {
    let report = replay(recording, bar)?;
    let figures = report.channels.iter().map(|channel| {
        let HeldOut { raw_rms_m, calibrated_rms_m, .. } = channel.rms;
        (channel.channel.name(), [raw_rms_m, calibrated_rms_m])
    });
    let remarks = remarks(figures, recording.meta.geometry.pitch_m);
    let text = text(recording, &report);
    let figures = Fitted { recording: place, report, remarks, findings };
    Ok(Answer { figures: Figures::Fitted(figures), text })
}

fn apply(
    recording: &Recording,
    place: String,
    path: &Path,
    findings: Vec<Finding>,
) -> Result<Answer> {
    let g_p = applied(recording, &CalibrationFile::read(path)?)?;
    let figures = [("g_p".to_owned(), [g_p.raw_rms_m, g_p.calibrated_rms_m])];
    let remarks = remarks(figures, recording.meta.geometry.pitch_m);
    let [raw, calibrated] = [g_p.raw_rms_m, g_p.calibrated_rms_m].map(micrometres);
    let text = format!(
        "{}: {} samples, g_p {raw} -> {calibrated} µm rms, nothing fitted",
        recording.meta.device, g_p.samples
    );
    let calibration = path.display().to_string();
    let figures = OfCalibration { calibration, findings, g_p, recording: place, remarks };
    Ok(Answer { figures: Figures::OfCalibration(figures), text })
}

/// Says what looks wrong on standard error, and gives the exit code: 1 where the figures cannot be a sensor's.
fn warned(remarks: &[Remark]) -> ExitCode {
    remarks.iter().for_each(|remark| warn(&remark.text));
    if remarks.iter().any(|remark| remark.of_the_pitch) {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}

fn text(recording: &Recording, report: &Report) -> String {
    let channels: Vec<Vec<String>> = report
        .channels
        .iter()
        .map(|channel| {
            let rms = [
                channel.rms.raw_rms_m,
                channel.rms.calibrated_rms_m,
                channel.rms.batch_f64_rms_m,
            ];
            let mut row = vec![
                channel.channel.name(),
                channel.fitted.to_string(),
                channel.held_out.to_string(),
            ];
            row.extend(rms.map(micrometres));
            row
        })
        .collect();
    let header = [
        "residual, rms in µm",
        "fitted",
        "held out",
        "raw",
        "equation (3), f32",
        "batch, f64",
    ];
    let mut text = format!(
        "{}: {} samples\n{}",
        recording.meta.device,
        recording.samples.len(),
        table(&header, &channels)
    );
    for channel in &report.channels {
        if let Some(rms_m) = channel.reference_phase_rms_m {
            let name = channel.channel.name();
            text += &format!(
                "\n{name}: {} µm with equation (3)'s orders in the phase of the reference",
                micrometres(rms_m)
            );
        }
    }
    if !report.position.is_empty() {
        let rows: Vec<Vec<String>> = report
            .position
            .iter()
            .map(|position| {
                let rms = [position.raw_rms_m, position.calibrated_rms_m].map(micrometres);
                [
                    vec![position.axis.to_owned(), position.samples.to_string()],
                    rms.to_vec(),
                ]
                .concat()
            })
            .collect();
        text += "\n\n";
        text += &table(
            &[
                "position against the reference, rms in µm",
                "samples",
                "raw",
                "calibrated",
            ],
            &rows,
        );
    }
    text
}
