//! Reading a recording, and what a file of another program lacks to be one.

use crate::META_KEY;
use crate::guard::guarded;
use crate::values::{Content, Meaning, Opened};
use parquet::data_type::ByteArray;
use recording::{Column, Error, Recording, Table};
use std::path::Path;

/// Reads and checks the recording in a file; the first sample is row 1.
///
/// # Errors
/// One [`Error`] for the first thing that is wrong, naming file, row and column, and how to get what is wanted.
pub fn read(path: &Path) -> Result<Recording, Error> {
    guarded(path, || {
        let table = table(&Opened::open(path)?)?;
        Recording::of_table(path, table).map_err(|error| with_way_out(path, error))
    })
}

/// True of a file that holds a recording, by what it says of itself.
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    let said = guarded(path, || Ok(Opened::open(path)?.said(META_KEY).is_some()));
    said.unwrap_or(false)
}

fn table(file: &Opened) -> Result<Table, Error> {
    let mut table = Table {
        meta: match file.said(META_KEY) {
            Some(text) => text.to_owned(),
            None => return Err(without_meta(file)),
        },
        ..Table::default()
    };
    for (place, (name, meaning)) in file.columns().into_iter().enumerate() {
        if !Table::takes(&name) {
            table.left_aside.push(name);
            continue;
        }
        let twice = name == "run" && !table.runs.is_empty()
            || table.columns.iter().any(|(other, _)| *other == name);
        if twice {
            return Err(
                Error::new(file.path(), "the name a second time", "each column once").column(name),
            );
        }
        match (name.as_str(), meaning) {
            ("run", Meaning::Text) => table.runs = runs(file, place)?,
            ("run", _) => return Err(refused(file, place, &name, "text")),
            _ => table
                .columns
                .push((name.clone(), numbers(file, place, &name, meaning)?)),
        }
    }
    Ok(table)
}

/// Values of a column of numbers. One of another type is taken where it holds nothing: programs guess at types of empty columns.
fn numbers(file: &Opened, place: usize, name: &str, meaning: Meaning) -> Result<Vec<f64>, Error> {
    match meaning {
        Meaning::Number | Meaning::Unsigned | Meaning::Decimal(_) => match file.content(place)? {
            Content::Numbers(numbers) => Ok(numbers),
            Content::Texts(_) => Err(refused(file, place, name, "numbers")),
        },
        Meaning::Other => Err(refused(file, place, name, "numbers")),
        _ => {
            let content = file.content(place)?;
            match content.is_nothing() {
                true => Ok(vec![f64::NAN; content.len()]),
                false => Err(refused(file, place, name, "numbers")),
            }
        }
    }
}

/// Neighbouring samples of one name as one run.
fn runs(file: &Opened, place: usize) -> Result<Vec<(String, usize)>, Error> {
    let mut runs: Vec<(String, usize)> = Vec::new();
    let Content::Texts(texts) = file.content(place)? else {
        return Err(refused(file, place, "run", "text"));
    };
    for (row, text) in texts.iter().enumerate() {
        let bytes = text.as_ref().map_or(&b""[..], ByteArray::data);
        match runs.last_mut() {
            Some((last, count)) if last.as_bytes() == bytes => *count += 1,
            _ => match std::str::from_utf8(bytes) {
                Ok(name) => runs.push((name.to_owned(), 1)),
                Err(_) => {
                    let error =
                        Error::new(file.path(), recording::excerpt(bytes), "a name in UTF-8");
                    return Err(error.row(1 + row as u64).column("run"));
                }
            },
        }
    }
    Ok(runs)
}

/// A column of another type, and how programs make it of the wanted one.
fn refused(file: &Opened, place: usize, name: &str, wanted: &str) -> Error {
    let found = file.type_name(place);
    let way = match (wanted, found.as_str()) {
        ("text", _) => format!("CAST({name} AS VARCHAR) in DuckDB, .astype(str) in pandas"),
        (_, "a TIMESTAMP") => {
            format!(
                "seconds: epoch_ns({name}) / 1e9 in DuckDB, ({name} - {name}.iloc[0]).dt.total_seconds() in pandas"
            )
        }
        _ => format!("CAST({name} AS DOUBLE) in DuckDB, .astype(float) in pandas"),
    };
    Error::new(file.path(), found, format!("{wanted}; {way}")).column(name)
}

/// A file of another program's, which says nothing of the sensor. What its columns lack is said as well.
fn without_meta(file: &Opened) -> Error {
    let there: Vec<String> = file.columns().into_iter().map(|(name, _)| name).collect();
    let known = there
        .iter()
        .filter(|name| Column::by_name(name).is_some())
        .count();
    let found = format!("no {META_KEY} in its metadata, and {known} of the layout's columns");
    let wanted = match known {
        0 => {
            "a recording; `courier convert` makes one of a log: `courier convert FILE` lists the columns"
        }
        _ => {
            "that text, which states lengths, converter and noise; `courier convert FILE OUT --pitch LENGTH` measures and adds it"
        }
    };
    Error::new(file.path(), found, wanted)
}

/// What tells how to get a column that is missing.
fn with_way_out(path: &Path, mut error: Error) -> Error {
    let is_column = error.file == path && error.row.is_none() && error.found == "none";
    if is_column {
        error.wanted += "; `courier convert FILE OUT` makes it of what there is";
    }
    error
}
