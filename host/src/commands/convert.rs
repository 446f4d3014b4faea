//! `courier convert LOG.csv OUT`.

use crate::conversion::{as_json, columns, columns_as_json, reformed, reformed_as_json, told};
use crate::destination::Destination;
use crate::json::Json;
use crate::logs::{self, Reading};
use crate::output::{Files, Kind};
use crate::recordings;
use crate::terminal::warn;
use anyhow::{Context, Result, ensure};
use convert::{Asked, Order, Runs, Stated, Target, length_m};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Make a recording of any log: columns by name, units, tooth counts, runs; or put a recording into its other form.
///
/// Tables of text, NumPy files, logs of candump, moteus, ODrive and SimpleFOC, lines of JSON: recognised by what stands in them. Of tables commas, semicolons, tabs or blanks between columns, decimal commas, a header behind a #, a row of units: recognised. Columns
/// that have a recording's names already are taken as they are. Without --column, and without such names, it
/// lists what the log holds and suggests the options.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The log, or a recording.
    log: PathBuf,
    /// Folder to make, or a file whose name ends in .parquet or .mcap. Without one nothing is written: what the log holds is listed.
    folder: Option<PathBuf>,
    /// Where a column of the recording comes from: TARGET=COLUMN[:UNIT][*FACTOR or /DIVISOR, +SUM or -DIFFERENCE]; may be repeated.
    /// #3 is the third column. Units: s ms us; m mm um nm inch; deg rad turn; C K F; counts V mV.
    #[arg(long, value_name = "TARGET=COLUMN", value_parser = Asked::parse)]
    column: Vec<Asked>,
    /// Rows a second, where the log has no time or a coarse one.
    #[arg(long, value_name = "HZ")]
    rate_hz: Option<f64>,
    /// What separates runs: rests, reversals, one (all is one run) or column:NAME [default: rests or reversals, as found].
    #[arg(long, value_name = "HOW", value_parser = runs)]
    runs: Option<RunsBy>,
    /// Length of one signal period, as 1.016mm; 1mm for a sensor on a shaft.
    #[arg(long, alias = "pitch-m", value_name = "LENGTH", value_parser = length_m)]
    pitch: Option<f64>,
    /// Signal periods of one turn of the shaft, where the reference is an angle [default: 1].
    #[arg(long, value_name = "N")]
    periods_per_turn: Option<f64>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    meta: Box<Meta>,
    /// Print what would be done and write nothing.
    #[arg(long)]
    dry_run: bool,
    /// Replace the recording that is there.
    #[arg(long)]
    force: bool,
    /// Write a .parquet file of half to a sixth of the bytes where the log has few digits; pandas then sees decimals in place of floats.
    #[arg(long)]
    compact: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("a conversion", &["log", "rows", "columns"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = match recordings::is_recording(&self.log) {
            true => Files::default().reads_recording(&self.log),
            false => self.reading.files(Files::default().reads(&self.log)),
        };
        let files = match self.folder.as_ref().filter(|_| !self.dry_run) {
            Some(folder) => files.fills(folder),
            None => files,
        };
        files.json(&self.json, ANSWER)
    }
}

const EXAMPLES: &str = "Examples:
  courier convert examples/encoder-log/log.csv
  courier convert examples/encoder-log/log.csv my-encoder --column t_s=time:ms --column q1s=sin --column q1c=cos --column ref_x_m=stage:mm --column temp_c=board:C --pitch 1.016mm

What each option means, by example: docs/your-sensor.md; logs of other programs: docs/other-logs.md; what a recording is: docs/recording.md.";

/// What recording.toml says. What is measured where it is not stated is told.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What recording.toml says")]
struct Meta {
    /// Bits of the converter, with sign [default: 16, or as many as the counts need].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=32))]
    adc_bits: Option<u32>,
    /// Input at the converter's full scale, in the log's unit, where sine and cosine are no counts.
    #[arg(long, value_name = "VALUE")]
    full_scale: Option<f64>,
    /// Amplitude of sine and cosine, counts [default: measured].
    #[arg(long, value_name = "N")]
    amplitude_counts: Option<f64>,
    /// Noise of each of them, rms counts [default: measured].
    #[arg(long, value_name = "N")]
    noise_counts: Option<f64>,
    /// Noise of logged positions, as 10nm [default: measured].
    #[arg(long, alias = "position-noise-m", value_name = "LENGTH", value_parser = length_m)]
    position_noise: Option<f64>,
    /// Distance between the two segments of a pair, where there are two.
    #[arg(long, alias = "span-m", value_name = "LENGTH", value_parser = length_m)]
    span: Option<f64>,
    /// Lateral offset of the segments, where there are four.
    #[arg(long, alias = "lateral-m", value_name = "LENGTH", allow_hyphen_values = true, value_parser = length_m)]
    lateral: Option<f64>,
    /// Height of the beacon over the diode, where electrodes are logged.
    #[arg(long, alias = "height-m", value_name = "LENGTH", value_parser = length_m)]
    height: Option<f64>,
    /// From the sensor's centre to the diode, along x.
    #[arg(long, alias = "lever-x-m", value_name = "LENGTH", allow_hyphen_values = true, value_parser = length_m)]
    lever_x: Option<f64>,
    /// From the sensor's centre to the diode, along y.
    #[arg(long, alias = "lever-y-m", value_name = "LENGTH", allow_hyphen_values = true, value_parser = length_m)]
    lever_y: Option<f64>,
    /// tan(psi) at a normalised deflection of 1.
    #[arg(long, value_name = "N")]
    tan_full_scale: Option<f64>,
    /// Sum of two opposite electrodes, counts [default: measured].
    #[arg(long, value_name = "N")]
    psd_sum_counts: Option<f64>,
    /// Noise of an electrode, rms counts [default: measured].
    #[arg(long, value_name = "N")]
    psd_noise_counts: Option<f64>,
    /// Name of the device [default: the log's].
    #[arg(long, value_name = "TEXT")]
    device: Option<String>,
    /// Where the log comes from [default: this command and the log's name].
    #[arg(long, value_name = "TEXT")]
    source: Option<String>,
    /// Number or name of the courier, to tell it from others.
    #[arg(long, value_name = "NAME")]
    courier_id: Option<String>,
    /// Number or name of the platen that it moved on.
    #[arg(long, value_name = "NAME")]
    platen_id: Option<String>,
}

/// What `--runs` names.
#[derive(Clone, Debug, PartialEq)]
enum RunsBy {
    Motion(Runs),
    Column(String),
}

fn runs(text: &str) -> Result<RunsBy, String> {
    Ok(match text.split_once(':') {
        Some(("column", name)) if !name.is_empty() => RunsBy::Column(name.to_owned()),
        None if text == "rests" => RunsBy::Motion(Runs::Rests),
        None if text == "reversals" => RunsBy::Motion(Runs::Reversals),
        None if text == "one" => RunsBy::Motion(Runs::One),
        _ => return Err("wanted rests, reversals, one or column:NAME".to_owned()),
    })
}

/// Reads the log, and lists its columns or writes the recording.
///
/// # Errors
/// A log that is no table, an option that does not fit it, a value that no recording holds, a folder that is not to be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    check(args)?;
    let order = order(args);
    if recordings::is_recording(&args.log) {
        return recording_to_form(args, &order);
    }
    let log = logs::read(&args.log, &args.reading, &args.column)?;
    let named = log.columns.iter().any(|column| Target::by_name(&column.name).is_some_and(|target| target != Target::Run));
    if args.folder.is_none() && args.column.is_empty() && !(args.dry_run && named) {
        args.json.tell(ANSWER, &columns_as_json(&args.log, &log), || columns(&args.log, &log))?;
        return Ok(ExitCode::SUCCESS);
    }
    let converted = convert::convert(&args.log, &log, &order)?;
    for warning in &converted.told.warnings {
        warn(&format!("{}; {}", warning.what, warning.mend));
    }
    let folder = args.folder.as_ref().filter(|_| !args.dry_run);
    if let Some(folder) = folder {
        write(args, folder, &converted.recording)?;
    }
    let written = folder.map(|folder| folder.display().to_string());
    let value = as_json(&args.log, &converted.told, written.as_deref());
    args.json.tell(ANSWER, &value, || told(&args.log, &converted.told, written.as_deref()))?;
    Ok(ExitCode::SUCCESS)
}

fn check(args: &Args) -> Result<()> {
    let above = |option: &str, value: Option<f64>, wanted: &str| {
        ensure!(value.is_none_or(|value| value.is_finite() && value > 0.0), "{option}: found {}, wanted {wanted}", value.unwrap_or_default());
        Ok(())
    };
    above("--rate-hz", args.rate_hz, "rows a second, above 0")?;
    above("--pitch", args.pitch, "a length above 0")?;
    above("--periods-per-turn", args.periods_per_turn, "a number above 0")?;
    above("--full-scale", args.meta.full_scale, "a number above 0")?;
    // What a conversion reads it does not replace.
    if let Some(folder) = &args.folder
        && let (Ok(log), Ok(folder)) = (args.log.canonicalize(), folder.canonicalize())
    {
        ensure!(!log.starts_with(&folder), "{}: found the log in it, wanted another folder for the recording", folder.display());
    }
    Ok(())
}

fn write(args: &Args, folder: &Path, recording: &recording::Recording) -> Result<()> {
    let to = Destination { folder: folder.to_owned(), force: args.force };
    match args.compact {
        true => to.write_compact(recording),
        false => to.write(recording),
    }
}

/// A recording into the other form, or into the same.
fn recording_to_form(args: &Args, order: &Order) -> Result<ExitCode> {
    let told = args.log.display();
    ensure!(*order == Order::default() && !args.reading.is_stated(), "{told}: found options of a log beside a recording, wanted none of them");
    let recording = recordings::read(&args.log)?;
    recording.warnings.iter().for_each(|line| warn(line));
    let wanted = "wanted where to write it: a folder, or a file whose name ends in .parquet or .mcap";
    let folder = args.folder.as_ref().with_context(|| format!("{told}: found a recording, {wanted}"))?;
    let folder = (!args.dry_run).then_some(folder);
    if let Some(folder) = folder {
        write(args, folder, &recording)?;
    }
    let written = folder.map(|folder| folder.display().to_string());
    let value = reformed_as_json(&args.log, &recording, written.as_deref());
    args.json.tell(ANSWER, &value, || reformed(&args.log, &recording, written.as_deref()))?;
    Ok(ExitCode::SUCCESS)
}

fn order(args: &Args) -> Order {
    let meta = &args.meta;
    let mut columns = args.column.clone();
    let runs = match &args.runs {
        None => Runs::Found,
        Some(RunsBy::Motion(runs)) => *runs,
        Some(RunsBy::Column(name)) => {
            columns.push(Asked { target: Target::Run, source: name.clone() });
            Runs::Found
        }
    };
    Order {
        columns,
        rate_hz: args.rate_hz,
        runs,
        pitch_m: args.pitch,
        periods_per_turn: args.periods_per_turn,
        stated: Stated {
            device: meta.device.clone(),
            source: meta.source.clone(),
            courier_id: meta.courier_id.clone(),
            platen_id: meta.platen_id.clone(),
            span_m: meta.span,
            lateral_m: meta.lateral,
            adc_bits: meta.adc_bits,
            full_scale: meta.full_scale,
            amplitude_counts: meta.amplitude_counts,
            noise_counts: meta.noise_counts,
            position_noise_m: meta.position_noise,
            psd_sum_counts: meta.psd_sum_counts,
            psd_noise_counts: meta.psd_noise_counts,
            height_m: meta.height,
            lever_m: [meta.lever_x, meta.lever_y],
            tan_full_scale: meta.tan_full_scale,
        },
    }
}
