//! Writing: whole columns into a file that is there only once it is whole.

use crate::META_KEY;
use crate::guard::told;
use crate::read::is_recording;
use crate::schema::{Stored, Values, properties, schema};
use parquet::column::writer::ColumnWriterImpl;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use recording::{COLUMNS, Column, Error, Existing, Meta, Samples, check_existing_file, write_file};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Samples that are stored together: some megabytes. DuckDB gives each such group to a processor of its own, and makes them as large.
const GROUP_ROWS: usize = 1 << 17;

/// Writes a recording that [`recording::Writer`] or [`recording::Recording::check`] has checked.
///
/// # Errors
/// `existing` forbids it, or a failure to write; nothing is left behind.
pub fn write(
    meta: &Meta,
    samples: &Samples,
    path: &Path,
    existing: Existing,
) -> std::result::Result<(), Error> {
    put(meta, samples, path, existing, columns(samples))
}

/// The same in less place: of each column the encoding that takes the least, by Zstandard; and numbers that a log wrote with few digits
/// behind the point as DECIMAL, which SQL takes as numbers, and pandas as objects of Python's.
///
/// # Errors
/// As [`write()`].
pub fn write_compact(
    meta: &Meta,
    samples: &Samples,
    path: &Path,
    existing: Existing,
) -> std::result::Result<(), Error> {
    let rows = samples.len();
    let columns: Result<Vec<Stored>> = columns(samples)
        .into_iter()
        .map(|column| smallest(column.decimal(), rows))
        .collect();
    let columns = columns.map_err(|error| told(path, &error))?;
    put(meta, samples, path, existing, columns)
}

/// A column in that of its ways that takes the fewest bytes: each is tried.
fn smallest(column: Stored<'_>, rows: usize) -> Result<Stored<'_>> {
    let mut best: Option<(usize, Stored)> = None;
    for way in column.ways() {
        let one = std::slice::from_ref(&way);
        let mut bytes = Vec::new();
        fill(&mut bytes, "column", one, rows, &[])?;
        if best.as_ref().is_none_or(|(least, _)| bytes.len() < *least) {
            best = Some((bytes.len(), way));
        }
    }
    best.map(|(_, way)| way)
        .ok_or_else(|| ParquetError::General("a column without a way to store it".into()))
}

fn put(
    meta: &Meta,
    samples: &Samples,
    path: &Path,
    existing: Existing,
    columns: Vec<Stored<'_>>,
) -> std::result::Result<(), Error> {
    check_existing(path, existing)?;
    let said = [
        (META_KEY, meta.to_toml()),
        ("courier_id", meta.names.courier_id.clone()),
        ("platen_id", meta.names.platen_id.clone()),
        ("beacon_id", meta.names.beacon_id.clone()),
        ("firmware", meta.names.firmware.clone()),
    ];
    let said: Vec<(&str, String)> = said
        .into_iter()
        .filter(|(_, text)| !text.is_empty())
        .collect();
    write_columns(
        path,
        "recording",
        &columns,
        samples.len(),
        &said,
        existing == Existing::ReplaceRecording,
    )
}

/// Refuses a file that `existing` forbids to replace, and a place where no file can be.
///
/// # Errors
/// Something else than a recording is there, or there is anything and nothing may be replaced.
pub fn check_existing(path: &Path, existing: Existing) -> std::result::Result<(), Error> {
    check_existing_file(path, existing, is_recording)
}

/// Columns that hold a value, and those that must be there beside them.
fn columns(samples: &Samples) -> Vec<Stored<'_>> {
    let needed = |column: Column| column.companions().iter().any(|one| samples.has(*one));
    let nothing = vec![f64::NAN; samples.len()];
    let numbers = |(column, name): (Column, &str)| {
        let values = match samples.column(column) {
            [] => nothing.as_slice(),
            values => values,
        };
        let is_count = matches!(
            column,
            Column::Sine(_) | Column::Cosine(_) | Column::Teeth(_) | Column::Electrode(_)
        );
        match is_count {
            true => Stored::numbers(name, values),
            false => Stored::reals(name, values),
        }
    };
    let mut columns: Vec<Stored> = COLUMNS
        .into_iter()
        .filter(|(column, _)| needed(*column))
        .map(numbers)
        .collect();
    if samples.run_names().iter().any(|name| !name.is_empty()) {
        let runs = (0..samples.len()).map(|row| samples.run(row)).collect();
        columns.insert(1, Stored::texts("run", runs));
    }
    columns.extend(
        samples
            .logged()
            .iter()
            .map(|logged| Stored::reals(&logged.name, &logged.values)),
    );
    columns
}

/// Writes columns of so many rows each, with what the file says of itself.
pub(crate) fn write_columns(
    path: &Path,
    name: &str,
    columns: &[Stored],
    rows: usize,
    said: &[(&str, String)],
    replace: bool,
) -> std::result::Result<(), Error> {
    write_file(path, replace, |file| {
        fill(file, name, columns, rows, said).map_err(|error| error.to_string())
    })
}

fn fill<W: Write + Send>(
    file: W,
    name: &str,
    columns: &[Stored],
    rows: usize,
    said: &[(&str, String)],
) -> Result<()> {
    let properties = Arc::new(properties(columns));
    let mut writer = SerializedFileWriter::new(file, schema(name, columns)?, properties)?;
    // Where each column's values of the next group begin: those that were not measured take no place among them.
    let mut begins = vec![0; columns.len()];
    for first in (0..rows).step_by(GROUP_ROWS) {
        let group = first..rows.min(first + GROUP_ROWS);
        let mut into = writer.next_row_group()?;
        for (column, begin) in columns.iter().zip(&mut begins) {
            let levels = column.levels.as_ref().map(|levels| &levels[group.clone()]);
            let count = levels.map_or(group.len(), |levels| {
                levels.iter().filter(|level| **level > 0).count()
            });
            write_column(&mut into, column, *begin..*begin + count, levels)?;
            *begin += count;
        }
        into.close()?;
    }
    for (key, text) in said {
        writer.append_key_value_metadata(KeyValue::new((*key).to_owned(), text.clone()));
    }
    writer.close().map(drop)
}

fn write_column<W: Write + Send>(
    into: &mut SerializedRowGroupWriter<W>,
    column: &Stored,
    range: std::ops::Range<usize>,
    levels: Option<&[i16]>,
) -> Result<()> {
    let Some(mut writer) = into.next_column()? else {
        return Ok(());
    };
    match &column.values {
        Values::Whole(values) => batch(writer.typed::<Int32Type>(), &values[range], levels)?,
        Values::Real(values) => batch(writer.typed::<DoubleType>(), &values[range], levels)?,
        Values::Decimal(values, _) => {
            batch(writer.typed::<Int64Type>(), &values[range], levels)?;
        }
        Values::Text(values) => {
            let texts: Vec<ByteArray> = values[range]
                .iter()
                .map(|text| ByteArray::from(*text))
                .collect();
            batch(writer.typed::<ByteArrayType>(), &texts, levels)?;
        }
    }
    writer.close()
}

fn batch<T: DataType>(
    writer: &mut ColumnWriterImpl<T>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<()> {
    writer.write_batch(values, levels, None).map(drop)
}
