//! One function a command: words of options in, the command's JSON and text out.

use crate::recording::Recording;
use crate::work::{done, parsed};
use courier::commands::{self, Command, encoder::Form};
use courier::learned;
use courier::provenance::origin_of;
use diagnosis::progress::Stage;
use indicatif::ProgressBar;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;
use std::ffi::OsString;
use std::sync::Arc;

/// JSON as the command prints it, and its text.
type Told = (String, String);

/// Nobody looks at the stages of the work.
fn unwatched(_: Stage) {}

fn json(value: &impl Serialize) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(value)?)
}

/// The words of one command never give another.
fn another() -> PyErr {
    PyRuntimeError::new_err("found the options of another command")
}

/// A diagnosis: JSON, text, the model's file where there is one, the report's page and the likeliest sets where they were asked for.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    recording: &Recording,
    words: Vec<OsString>,
    page_for: Option<String>,
) -> PyResult<(Told, [Option<String>; 3])> {
    let Command::Diagnose(args) = parsed(py, "diagnose", words)? else {
        return Err(another());
    };
    let (path, recording) = (recording.path.clone(), Arc::clone(&recording.inner));
    done(py, "diagnose", move |_| {
        args.check()?;
        let answer = commands::diagnose::answer(&args, &recording, &unwatched);
        let explained = commands::diagnose::explained(&args, &answer);
        let text = commands::diagnose::told(&args, &answer, explained.as_deref());
        let model = answer.model.as_ref().map(commands::diagnose::model_text);
        let page = |command: String| -> anyhow::Result<String> {
            let mut origin = origin_of(&path, &recording, None)?;
            origin.command = command;
            Ok(args.page(&answer, &origin))
        };
        let page = page_for.map(page).transpose()?;
        let told = (json(&answer.diagnosis)?, text);
        Ok((told, [model.transpose()?, page, explained]))
    })
}

/// Many recordings into a table in a folder: how many were what, as JSON and text.
#[pyfunction]
pub fn diagnose_many(
    py: Python<'_>,
    out: std::path::PathBuf,
    words: Vec<OsString>,
) -> PyResult<Told> {
    let Command::Diagnose(args) = parsed(py, "diagnose", words)? else {
        return Err(another());
    };
    done(py, "diagnose", move |_| {
        args.check()?;
        args.files().check()?;
        let order = args.order(&out);
        let done = courier::many::run(&order, &|| ())?;
        Ok((json(&done)?, commands::diagnose_many::text(&order, &done)))
    })
}

/// A model, its name and its text, on another recording.
#[pyfunction]
pub fn check(py: Python<'_>, model: (String, String), recording: &Recording) -> PyResult<Told> {
    let (place, recording) = (
        recording.path.display().to_string(),
        Arc::clone(&recording.inner),
    );
    done(py, "check", move |tell| {
        let (name, text) = &model;
        let model = commands::check::model(name, text)?;
        let answer =
            commands::check::answer((name, &model), (&place, &recording), &unwatched, tell)?;
        Ok((json(&answer.check)?, answer.text))
    })
}

/// A recording through the firmware's signal path.
#[pyfunction]
pub fn replay(py: Python<'_>, recording: &Recording, words: Vec<OsString>) -> PyResult<Told> {
    let Command::Replay(args) = parsed(py, "replay", words)? else {
        return Err(another());
    };
    let recording = Arc::clone(&recording.inner);
    done(py, "replay", move |tell| {
        let answer = commands::replay::answer(&args, &recording, &ProgressBar::hidden(), tell)?;
        Ok((json(&answer)?, answer.text))
    })
}

/// What a planned motion can tell.
#[pyfunction]
pub fn isolability(py: Python<'_>, words: Vec<OsString>) -> PyResult<Told> {
    let Command::Isolability(args) = parsed(py, "isolability", words)? else {
        return Err(another());
    };
    done(py, "isolability", move |_| {
        let answer = commands::isolability::answer(&args)?;
        Ok((json(&answer)?, commands::isolability::report(&answer)))
    })
}

/// The errors of one encoder: JSON, text, and its constants in C, for moteus and for SimpleFOC.
#[pyfunction]
pub fn encoder(py: Python<'_>, words: Vec<OsString>) -> PyResult<(String, String, [String; 3])> {
    let Command::Encoder(args) = parsed(py, "encoder", words)? else {
        return Err(another());
    };
    done(py, "encoder", move |tell| {
        let learned = commands::encoder::answer(&args, tell)?;
        let (place, answer) = (&learned.place, &learned.answer);
        let told = learned::text(place, answer);
        let forms = [Form::C, Form::Moteus, Form::Simplefoc];
        let constants = forms.map(|form| args.constants(form, answer));
        Ok((json(&learned::as_json(place, answer))?, told, constants))
    })
}
