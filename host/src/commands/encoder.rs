//! `courier encoder LOG`.

use crate::calibration_file::CalibrationFile;
use crate::findings::{self, NOTHING};
use crate::json::Json;
use crate::kinds;
use crate::learned;
use crate::logs::{self, Reading};
use crate::output::{self, Files, Kind};
use crate::recordings;
use crate::terminal::{print, warn};
use anyhow::{Context, Result, anyhow, ensure};
use convert::{Asked, Order, Runs, length_m};
use encoder::{Answer, Input, LogUnit, Question, forms, learn};
use recording::{Geometry, Recording};
use std::path::PathBuf;
use std::process::ExitCode;

/// Tell the errors of one encoder from its own log, without a reference.
///
/// Sine and cosine of a shaft or slide that was spun by hand or motor, best both ways and at several speeds: offset, gain and angle of the
/// channels from the amplitude, and orders 1 to 8 of the angle from the smoothness of the motion, each with its standard deviation. A log of
/// positions will do as well; its amplitude then tells nothing. What this motion cannot tell is said, with the motion that would.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A log, as `courier convert` reads it, or a recording's folder.
    log: PathBuf,
    /// Where a column comes from, as in `courier convert`; may be repeated.
    #[arg(long, value_name = "TARGET=COLUMN", value_parser = Asked::parse)]
    column: Vec<Asked>,
    /// Rows a second, where the log has no time.
    #[arg(long, value_name = "HZ")]
    rate_hz: Option<f64>,
    /// Length of one signal period, as 1.016mm [default: 1 mm, or the recording's].
    #[arg(long, value_name = "LENGTH", value_parser = length_m)]
    pitch: Option<f64>,
    /// Signal periods of one turn of the shaft: single poles and eccentricity are learned too.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    periods_per_turn: Option<u32>,
    #[command(flatten)]
    reading: Reading,
    /// Which segment, where there are several.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=4))]
    segment: u8,
    /// Print the constants for another program in place of the table.
    #[arg(long, value_enum, value_name = "FORM")]
    form: Option<Form>,
    /// Write a calibration of the segment to this file, JSON, as `courier export` does.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite the file.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: Json,
}

/// Programs that constants are written for.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Form {
    /// C: constants and a function.
    C,
    /// Commands for moteus.
    Moteus,
    /// A table for SimpleFOC's CalibratedSensor.
    Simplefoc,
}

const EXAMPLES: &str = "Examples:
  courier encoder examples/encoder-log/log.csv --column t_s=time:ms --column q1s=sin --column q1c=cos --pitch 1.016mm
  courier encoder my-ring --periods-per-turn 25 --form simplefoc

How it is done, and which motion tells what: docs/encoder.md.";

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an encoder's errors", &["log", "stretches", "harmonics"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = match recordings::is_recording(&self.log) {
            true => Files::default().reads_recording(&self.log),
            false => self.reading.files(Files::default().reads(&self.log)),
        };
        files.writes_new(self.out.as_ref(), kinds::CALIBRATION, self.force).json(&self.json, ANSWER)
    }
}

/// Reads, learns, tells.
///
/// # Errors
/// A log or recording that cannot be read, has no such segment or too little motion, or a file that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    ensure!(args.form.is_none() || !args.json.is_printed() && args.json.file().is_none(), "--form: found --json beside it, wanted one of the two");
    let Learned { place, answer, geometry } = answer(args, &mut warn)?;
    if let Some(path) = &args.out {
        if let Some(turn) = &answer.turn {
            warn(&format!(
                "{}: without the {} orders of the turn, since a calibration knows one signal period; --form c or simplefoc has them",
                path.display(),
                turn.orders.len()
            ));
        }
        let calibration = learned::calibration(&answer, args.segment(), &geometry)?;
        output::write(path, kinds::CALIBRATION, CalibrationFile::new(calibration).to_json()?.as_bytes())?;
    }
    match args.form {
        Some(form) => print(args.constants(form, &answer).trim_end())?,
        None => args.json.tell(ANSWER, &learned::as_json(&place, &answer), || learned::text(&place, &answer))?,
    }
    Ok(ExitCode::SUCCESS)
}

/// What was learned, and of what.
#[derive(Clone, Debug)]
pub struct Learned {
    /// The log or recording, as it was named.
    pub place: String,
    /// The errors.
    pub answer: Answer,
    /// As stated, or as the options say.
    pub geometry: Geometry,
}

/// Reads and learns. What is worth a word goes to `tell`.
///
/// # Errors
/// As [`run`], but for what is written.
pub fn answer(args: &Args, tell: &mut dyn FnMut(&str)) -> Result<Learned> {
    let place = args.log.display().to_string();
    let (recording, units) = read(args, tell)?;
    findings::check_telling(&recording, &place, NOTHING, tell)?;
    let segment = args.segment();
    let input = Input::of(&recording, segment);
    let number = args.segment;
    let mut input = input.ok_or_else(|| anyhow!("{place}: found no output of segment {number}, wanted q{number}s and q{number}c, or p{number}_m"))?;
    input.unit = units[segment];
    let question = Question { periods_per_turn: args.periods_per_turn };
    let answer = learn(&input, &question).with_context(|| place.clone())?;
    Ok(Learned { place, answer, geometry: recording.meta.geometry })
}

impl Args {
    /// The segment, from 0.
    fn segment(&self) -> usize {
        usize::from(self.segment - 1)
    }

    /// The constants for another program.
    #[must_use]
    pub fn constants(&self, form: Form, answer: &Answer) -> String {
        match form {
            Form::C => forms::c(answer),
            Form::Moteus => forms::moteus(answer),
            Form::Simplefoc => forms::simplefoc(answer, self.periods_per_turn.unwrap_or(1)),
        }
    }
}

/// The recording, and how its counts came from the log's values.
fn read(args: &Args, tell: &mut dyn FnMut(&str)) -> Result<(Recording, [LogUnit; 4])> {
    let mut units = [LogUnit::default(); 4];
    if recordings::is_recording(&args.log) {
        ensure!(
            args.column.is_empty() && args.rate_hz.is_none() && args.pitch.is_none() && !args.reading.is_stated(),
            "{}: found --column, --rate-hz, --pitch, --dbc or --rows-of beside a recording, wanted them beside a log",
            args.log.display()
        );
        let recording = recordings::read(&args.log)?;
        recording.warnings.iter().for_each(|line| tell(line));
        return Ok((recording, units));
    }
    let above = |option: &str, value: Option<f64>| {
        ensure!(value.is_none_or(|value| value.is_finite() && value > 0.0), "{option}: found {}, wanted a number above 0", value.unwrap_or_default());
        Ok(())
    };
    above("--rate-hz", args.rate_hz)?;
    above("--pitch", args.pitch)?;
    let log = logs::read(&args.log, &args.reading, &args.column)?;
    let order = Order {
        columns: args.column.clone(),
        rate_hz: args.rate_hz,
        pitch_m: args.pitch,
        periods_per_turn: args.periods_per_turn.map(f64::from),
        runs: Runs::One,
        ..Order::default()
    };
    let converted = convert::convert(&args.log, &log, &order)?;
    converted.told.warnings.iter().for_each(|warning| tell(&format!("{}; {}", warning.what, warning.mend)));
    for pair in &converted.told.pairs {
        units[pair.segment] = LogUnit { centre: pair.centre, scale: pair.scale };
    }
    Ok((converted.recording, units))
}
