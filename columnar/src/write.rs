//! Writing: whole columns into a file that is there only once it is whole.

use crate::META_KEY;
use crate::read::is_recording;
use crate::schema::{Stored, Values, properties, schema};
use parquet::column::writer::ColumnWriterImpl;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int32Type};
use parquet::errors::Result;
use parquet::file::metadata::KeyValue;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use recording::{COLUMNS, Column, Error, Existing, Meta, Samples, unfinished_file};
use std::fs::File;
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
    check_existing(path, existing)?;
    let columns = columns(samples);
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
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Error::new(
            folder,
            "no such folder",
            "a folder to write into",
        ));
    }
    let Ok(there) = std::fs::symlink_metadata(path) else {
        return Ok(());
    };
    let (wanted, found) = match existing {
        Existing::Refuse => ("a new file", "a file"),
        Existing::ReplaceRecording if there.is_file() && is_recording(path) => return Ok(()),
        Existing::ReplaceRecording => ("a new file, or a recording", "no recording"),
    };
    let found = if there.is_dir() { "a folder" } else { found };
    Err(Error::new(path, found, wanted))
}

fn folder_of(path: &Path) -> &Path {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
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
    let failed = |found: String| Error::new(path, found, "room to write");
    let file = unfinished_file(folder_of(path)).map_err(|error| failed(error.to_string()))?;
    let written = file
        .as_file()
        .try_clone()
        .map_err(|error| failed(error.to_string()))?;
    fill(written, name, columns, rows, said).map_err(|error| failed(error.to_string()))?;
    file.as_file()
        .sync_all()
        .map_err(|error| failed(error.to_string()))?;
    let placed = match replace {
        true => file.persist(path).map_err(|error| error.error),
        false => file.persist_noclobber(path).map_err(|error| error.error),
    };
    placed.map(drop).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => Error::new(path, "a file", "a new file"),
        _ => failed(error.to_string()),
    })
}

fn fill(
    file: File,
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

fn write_column(
    into: &mut SerializedRowGroupWriter<File>,
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
