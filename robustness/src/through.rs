//! A recording through every command that reads one.

use anyhow::{Context, Result};
use command_line::program_error::caught;
use courier::commands::diagnose::text;
use courier::replay::replay;
use courier::teeth::{estimate, poses_of};
use diagnosis::{Model, Options, check_fully, diagnose_fully};
use indicatif::ProgressBar;
use recording::Recording;

/// A command that ended in an error of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crash {
    /// Which.
    pub command: &'static str,
    /// Where it panicked and what that said.
    pub panic: String,
}

/// What came of one recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Commands that panicked.
    pub crashes: Vec<Crash>,
    /// Commands that gave an answer; the others refused in a line.
    pub answered: Vec<&'static str>,
}

/// Sends a recording through `diagnose`, `replay` and `map`, and the model that the diagnosis gives through `check` on the same
/// recording and on another one.
#[must_use]
pub fn through(recording: &Recording, other: &Recording) -> Outcome {
    let mut outcome = Outcome::default();
    let mut model = None;
    outcome.take("diagnose", || {
        let answer = diagnose_fully(recording, "random", &Options::default());
        let _ = text(&answer.diagnosis, report::headline::RESOLUTION_M);
        let answered = answer.model.is_some();
        model = answer.model;
        answered
    });
    if let Some(model) = model {
        for there in [recording, other] {
            outcome.take("check", || checked(&model, there).is_ok());
        }
    }
    outcome.take("replay", || {
        replay(recording, &ProgressBar::hidden()).is_ok()
    });
    outcome.take("map", || mapped(recording).is_ok());
    outcome
}

impl Outcome {
    fn take(&mut self, command: &'static str, work: impl FnOnce() -> bool) {
        match caught(work) {
            Ok(true) => self.answered.push(command),
            Ok(false) => {}
            Err(panic) => self.crashes.push(Crash { command, panic }),
        }
    }
}

/// As `courier check` does it: the model from a file.
fn checked(model: &Model, recording: &Recording) -> Result<()> {
    let text = serde_json::to_string(model).context("a model")?;
    let read: Model = serde_json::from_str(&text).context("a model")?;
    check_fully(&read, recording)?;
    Ok(())
}

fn mapped(recording: &Recording) -> Result<()> {
    let (setup, poses) = poses_of(recording)?;
    estimate(&setup, &poses, &mut || ()).map(drop)
}
