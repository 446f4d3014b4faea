//! `courier trace FILE`.

use super::acceptance::told;
use crate::acceptance::Step;
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::terminal::pairs;
use crate::trace::lines::Named;
use crate::trace::{Lines, Span, file, judge, megahertz};
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Judge what a logic analyser has recorded at a sensor board's pins: CONVST, BUSY, chip selects and buses.
///
/// Each step says what was found and, if it failed, what was wanted and where in the trace; the exit code is 1 if one failed. What the trace
/// cannot show is told as not measured: a line that is not recorded, or a time that is shorter than the instrument can tell. The board must
/// sample while the trace is taken: what it does with the converters at its start is another thing. 100 µs at 100 MS/s show all but slopes.
///
/// FILE is a value change dump (VCD), as PulseView, sigrok-cli and many instruments write it, or a table of levels (CSV): sigrok's, or one
/// with a column of times, such as Saleae's raw export. Lines are found by their channels' names: CONVST, BUSY, CS0, CS1, SCLK0, SCLK1,
/// DOUT0, DOUT1, RESET, NRST, or the pin (PC6).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  courier trace board.vcd\n  courier trace board.vcd --channel CONVST=D0 --channel BUSY=D1 --channel CS0=D2")]
pub struct Args {
    /// The instrument's file.
    file: PathBuf,
    /// Which channel is a line: LINE=CHANNEL; may be repeated.
    #[arg(long, value_name = "LINE=CHANNEL", value_parser = Named::parse)]
    channel: Vec<Named>,
    /// How often the instrument looked at the levels, millions a second [default: as the file says, or as its times show].
    #[arg(long, value_name = "MS/S")]
    rate_msps: Option<f64>,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier trace`", &["trace", "steps", "passed"]);

/// What came of it.
#[derive(Debug, Serialize)]
struct Report {
    trace: Told,
    steps: Vec<Step>,
    /// Whether something was measured and nothing failed.
    passed: bool,
}

/// The trace that was judged.
#[derive(Debug, Serialize)]
struct Told {
    file: String,
    seconds: f64,
    rate_hz: f64,
    /// Lines, and the channels that they are.
    lines: Vec<(&'static str, String)>,
}

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().reads(&self.file).json(&self.json, ANSWER)
    }
}

/// Reads, judges, prints.
///
/// # Errors
/// A file that is no trace, a channel that it has not, or no line of the board in it. A step that fails is no error: exit code 1.
pub fn run(args: &Args) -> Result<ExitCode> {
    let rate_hz = args.rate_msps.map(|rate| 1.0e6 * rate);
    ensure!(
        rate_hz.is_none_or(|rate_hz| rate_hz.is_finite() && rate_hz > 0.0),
        "--rate-msps: found {}, wanted a number above 0",
        args.rate_msps.unwrap_or_default()
    );
    let trace = file::read(&args.file, rate_hz)?;
    let span = trace.span;
    let name = args.file.display().to_string();
    let lines = Lines::of(trace, &args.channel).with_context(|| name.clone())?;
    let steps = judge(&lines, span);
    let report = Report {
        passed: is_passed(&steps),
        trace: describe(name, &lines, span),
        steps,
    };
    args.json.tell(ANSWER, &report, || text(&report))?;
    Ok(match report.passed {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn is_passed(steps: &[Step]) -> bool {
    let any = |passed| steps.iter().any(|step| step.passed == Some(passed));
    any(true) && !any(false)
}

fn describe(file: String, lines: &Lines, span: Span) -> Told {
    let lines = lines.told().into_iter();
    Told {
        file,
        seconds: span.end_s - span.begin_s,
        rate_hz: 1.0 / span.step_s,
        lines: lines.map(|(line, own)| (line, own.to_owned())).collect(),
    }
}

fn text(report: &Report) -> String {
    let trace = &report.trace;
    let head = format!("{:.3} ms at {} MS/s", 1.0e3 * trace.seconds, megahertz(trace.rate_hz));
    let mut rows = vec![("trace", head)];
    rows.extend(report.steps.iter().map(|step| (step.step, told(step))));
    let count = |passed| report.steps.iter().filter(|step| step.passed == passed).count();
    let verdict = match (count(Some(false)), count(Some(true))) {
        (0, 0) => "not passed: nothing could be measured".to_owned(),
        (0, _) => "passed".to_owned(),
        (1, _) => "failed: 1 step".to_owned(),
        (more, _) => format!("failed: {more} steps"),
    };
    let rest = match count(None) {
        0 => String::new(),
        more => format!("; {more} not measured"),
    };
    format!("{}\n{verdict}{rest}", pairs(&rows))
}
