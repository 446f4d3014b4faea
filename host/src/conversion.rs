//! What `courier convert` says: what a log holds, and what became of it.

use crate::terminal::table;
use convert::listing::{lacks, listing, suggestion};
use convert::{Log, Told, figures, quoted};
use recording::{COLUMNS, Recording};
use serde_json::{Value, json};
use std::path::Path;

/// The columns of a log with their ranges, and a command line to begin with.
#[must_use]
pub fn columns(file: &Path, log: &Log) -> String {
    let name = file.display().to_string();
    let row = |(place, column): (usize, convert::listing::Listed)| {
        let [low, high] = column
            .range
            .map_or([String::new(), String::new()], |range| range.map(figures));
        let guess = column.guess.unwrap_or_default();
        vec![
            format!("#{} {}", place + 1, column.name),
            column.numbers.to_string(),
            column.words.to_string(),
            low,
            high,
            guess,
        ]
    };
    let rows: Vec<Vec<String>> = listing(log).into_iter().enumerate().map(row).collect();
    let header = [
        "column",
        "numbers",
        "words",
        "lowest",
        "highest",
        "by its name",
    ];
    let notes: String = log
        .notes
        .iter()
        .map(|note| format!("\ndone: {note}"))
        .chain(lacks(log).map(|what| format!("\nlacking: {what}")))
        .collect();
    format!(
        "{name}: {} rows\n{}{notes}\nto begin with:\n  {}",
        log.rows(),
        table(&header, &rows),
        suggestion(log, &name)
    )
}

/// More runs than these are only counted.
const RUNS_NAMED: usize = 12;

/// What a conversion did, assumed and found; `written` is the folder of the recording, where there is one.
#[must_use]
pub fn told(file: &Path, told: &Told, written: Option<&str>) -> String {
    let rows: Vec<Vec<String>> = told
        .columns
        .iter()
        .map(|column| {
            vec![
                column.name.to_owned(),
                column.from.clone(),
                column.values.to_string(),
                figures(column.range[0]),
                figures(column.range[1]),
            ]
        })
        .collect();
    let mut text = format!(
        "{}: {} rows, {}\n{}",
        file.display(),
        told.rows,
        told.dialect,
        table(&["column", "from", "values", "lowest", "highest"], &rows)
    );
    text += &format!(
        "\ntime: {} s at {} samples a second",
        figures(told.duration_s),
        figures(told.rate_hz)
    );
    let runs: Vec<String> = told
        .runs
        .iter()
        .take(RUNS_NAMED)
        .map(|run| format!("{} ({})", run.name, run.samples))
        .collect();
    text += &format!(
        "\nruns: {}, separated by {}, with samples: {}",
        told.runs.len(),
        told.runs_by,
        runs.join(", ")
    );
    if told.runs.len() > RUNS_NAMED {
        text += &format!(" and {} more", told.runs.len() - RUNS_NAMED);
    }
    for done in &told.done {
        text += &format!("\ndone: {done}");
    }
    for assumed in &told.assumed {
        text += &format!(
            "\nnot stated: {} ({} states it)",
            assumed.what, assumed.option
        );
    }
    if !told.left_aside.is_empty() {
        text += &format!("\nleft aside: {}", told.left_aside.join(", "));
    }
    text + &last_line(written, told.rows)
}

/// What was written, and the next commands.
fn last_line(written: Option<&str>, rows: usize) -> String {
    let Some(place) = written.map(quoted) else {
        return "\nnothing written".to_owned();
    };
    format!(
        "\n{place}: {rows} samples written; next: courier replay {place}; courier diagnose {place}"
    )
}

/// What a recording holds that is put into another form; `written` is where, if it is.
#[must_use]
pub fn reformed(from: &Path, recording: &Recording, written: Option<&str>) -> String {
    let columns: Vec<&str> = held(recording).into_iter().map(|(name, _)| name).collect();
    let rows = recording.samples.len();
    format!(
        "{}: a recording of {rows} samples, with {}{}",
        from.display(),
        columns.join(", "),
        last_line(written, rows)
    )
}

/// The same for programs.
#[must_use]
pub fn reformed_as_json(from: &Path, recording: &Recording, written: Option<&str>) -> Value {
    let columns: Vec<Value> = held(recording)
        .into_iter()
        .map(|(name, values)| json!({"name": name, "values": values}))
        .collect();
    json!({"log": from.display().to_string(), "recording": written, "rows": recording.samples.len(), "columns": columns})
}

/// Columns with a value, and how many they have.
fn held(recording: &Recording) -> Vec<(&str, usize)> {
    let count = |values: &[f64]| values.iter().filter(|value| !value.is_nan()).count();
    let samples = &recording.samples;
    let layout = COLUMNS
        .into_iter()
        .filter(|(column, _)| samples.has(*column));
    let layout = layout.map(|(column, name)| (name, count(samples.column(column))));
    let beside = samples.logged().iter();
    layout
        .chain(beside.map(|logged| (logged.name.as_str(), count(&logged.values))))
        .collect()
}

/// The same for programs.
#[must_use]
pub fn as_json(file: &Path, told: &Told, written: Option<&str>) -> Value {
    let columns: Vec<Value> = told
        .columns
        .iter()
        .map(|column| json!({"name": column.name, "from": column.from, "values": column.values, "range": column.range}))
        .collect();
    let runs: Vec<Value> = told
        .runs
        .iter()
        .map(|run| json!({"name": run.name, "samples": run.samples, "times_s": run.times_s}))
        .collect();
    let assumed: Vec<Value> = told
        .assumed
        .iter()
        .map(|assumed| json!({"what": assumed.what, "option": assumed.option}))
        .collect();
    let warnings: Vec<Value> = told
        .warnings
        .iter()
        .map(|warning| json!({"what": warning.what, "mend": warning.mend}))
        .collect();
    json!({
        "log": file.display().to_string(),
        "recording": written,
        "rows": told.rows,
        "dialect": told.dialect,
        "duration_s": told.duration_s,
        "rate_hz": told.rate_hz,
        "columns": columns,
        "left_aside": told.left_aside,
        "runs_by": told.runs_by,
        "runs": runs,
        "done": told.done,
        "assumed": assumed,
        "warnings": warnings,
    })
}

/// A log's columns for programs.
#[must_use]
pub fn columns_as_json(file: &Path, log: &Log) -> Value {
    let columns: Vec<Value> = listing(log)
        .into_iter()
        .map(|column| json!({"name": column.name, "numbers": column.numbers, "words": column.words, "range": column.range, "guess": column.guess}))
        .collect();
    json!({"log": file.display().to_string(), "rows": log.rows(), "columns": columns, "done": log.notes, "lacking": lacks(log), "begin_with": suggestion(log, &file.display().to_string())})
}
