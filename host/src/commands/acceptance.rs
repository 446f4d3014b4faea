//! `courier acceptance`.

use crate::acceptance::{Report, Settings, Step, accept, cuts};
use crate::board::{Choice, Kind as BoardKind};
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::terminal::{pairs, progress};
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Duration;

/// Test a board as far as no instrument is needed: its self-test, restarts, sampling and commits.
///
/// Each step says what was found and, if it failed, what was wanted; the exit code is 1 if one failed. The calibration in force is stored
/// again and again meanwhile, so that both slots hold it in the end: `courier rollback` has nothing older to go back to then. What
/// needs an instrument is in docs/bring-up.md.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  courier --sim-flash board.bin acceptance --seconds 5 --commits 2"
)]
pub struct Args {
    /// Watch the board sampling for so many seconds of its own time.
    #[arg(long, default_value_t = 60.0, value_name = "S")]
    seconds: f64,
    /// Commits meanwhile, evenly spread. Flash endures some 10,000 erasures of a page, and a commit erases one of two.
    #[arg(long, default_value_t = 10, value_name = "N")]
    commits: u16,
    /// Restarts before.
    #[arg(long, default_value_t = 3, value_name = "N")]
    restarts: u16,
    /// Temperature beside the board by another thermometer, °C: compared with the board's own.
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    temperature_c: Option<f32>,
    /// A program that switches the board's supply off for a tenth of a second or more and on again, and then ends: commits are cut by it. For a
    /// board on a debug probe.
    #[arg(long, value_name = "PROGRAM")]
    cut_command: Option<PathBuf>,
    /// Supply cuts, if there is a program for them.
    #[arg(long, default_value_t = 1000, value_name = "N", requires = "cut_command")]
    cuts: u32,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier acceptance`", &["board", "steps", "passed"]);

/// Cuts come so much later one after the other, milliseconds, then from the beginning again: an erasure takes 25 ms, programming 12 ms.
const SPREAD: u32 = 100;
/// Longest run, seconds: a day.
const LONGEST_S: f64 = 86_400.0;

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// Runs every step and prints.
///
/// # Errors
/// A number out of range, or the board cannot be reached. A step that fails is no error: exit code 1.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    ensure!(
        args.seconds > 0.0 && args.seconds <= LONGEST_S,
        "--seconds: found {}, wanted above 0 to {LONGEST_S}",
        args.seconds
    );
    if let Some(temperature_c) = args.temperature_c {
        ensure!(temperature_c.is_finite(), "--temperature-c: found {temperature_c}, wanted a temperature");
    }
    ensure!(
        args.cut_command.is_none() || choice.kind() == BoardKind::Probe,
        "--cut-command: found a board without a supply of its own, wanted --probe"
    );
    let settings = Settings {
        seconds: args.seconds,
        commits: args.commits,
        restarts: args.restarts,
        temperature_c: args.temperature_c,
    };
    let mut board = choice.open()?;
    let bar = progress((1000.0 * args.seconds) as u64, "ms of sampling");
    let report = accept(&mut board.link, &settings, |passed| {
        bar.set_position(passed.as_millis() as u64);
    });
    bar.finish_and_clear();
    let mut report = report?;
    board.close()?;
    if let Some(program) = &args.cut_command {
        report.add(cut_by(program, args.cuts, choice)?);
    }
    args.json.tell(ANSWER, &report, || text(&report))?;
    Ok(match report.passed {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// Cuts the supply during commits, each a millisecond later after the program's begin than the one before, up to [`SPREAD`].
fn cut_by(program: &Path, times: u32, choice: &Choice) -> Result<Step> {
    let bar = progress(u64::from(times), "supply cuts");
    let begin = |number: u32| {
        let child = Command::new(program).spawn();
        let mut child = child.with_context(|| format!("--cut-command: {}", program.display()))?;
        std::thread::sleep(Duration::from_millis(u64::from(number % SPREAD)));
        Ok(move || {
            let ended = child.wait()?;
            ensure!(ended.success(), "--cut-command: found {ended}, wanted exit code 0");
            Ok(())
        })
    };
    let watch = |done| bar.set_position(u64::from(done));
    let cuts = cuts::cut(times, || choice.open(), begin, watch);
    bar.finish_and_clear();
    Ok(cuts::judged(&cuts?))
}

fn text(report: &Report) -> String {
    let rows: Vec<(&str, String)> = report.steps.iter().map(|step| (step.step, told(step))).collect();
    let failed = report.steps.iter().filter(|step| step.passed == Some(false)).count();
    let verdict = match failed {
        0 => "passed".to_owned(),
        1 => "failed: 1 step".to_owned(),
        more => format!("failed: {more} steps"),
    };
    format!("{}\n{verdict}", pairs(&rows))
}

/// A step's verdict on one line.
pub(super) fn told(step: &Step) -> String {
    let Step { passed, found, wanted, at_s, .. } = step;
    let at = at_s.map_or(String::new(), |at_s| format!(" at {:.6} ms", 1.0e3 * at_s));
    match passed {
        Some(true) => format!("passed: {found}"),
        Some(false) => format!("FAILED: found {found}{at}, wanted {wanted}"),
        None => format!("not measured: {found}"),
    }
}
