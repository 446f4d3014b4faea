//! Writing a recording row by row: checked like the reader checks, and gone unless finished; into a folder, or into a file of another form.

use crate::column::{COLUMNS, Column, CountLimits};
use crate::error::{Error, excerpt};
use crate::existing::{Existing, check_existing};
use crate::layout::{META_FILE, SAMPLES_FILE};
use crate::meta::Meta;
use crate::samples::{Logged, Row, Samples};
use crate::unfinished::{locked_file, unfinished_file};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a whole recording into a file, in a form other than the folder.
pub type WriteFile = fn(&Meta, &Samples, &Path, Existing) -> Result<(), Error>;

/// Where rows go until the recording is finished.
enum Rows {
    /// Into the table of a folder.
    Csv(Box<csv::Writer<NamedTempFile>>),
    /// Into memory, for a form that is written whole.
    Kept {
        samples: Box<Samples>,
        logged: Vec<Logged>,
        existing: Existing,
        write: WriteFile,
    },
}

/// Writes a recording. Dropped before [`Writer::finish`], it leaves the folder as it was.
pub struct Writer {
    folder: PathBuf,
    created: bool,
    finished: bool,
    meta: Meta,
    limits: CountLimits,
    rows: Option<Rows>,
    line: u64,
    last_time_s: f64,
    /// One row that has every column that any row had: what [`Meta`] is checked against.
    seen: Samples,
    seen_columns: [bool; COLUMNS.len()],
}

impl Writer {
    /// Begins a recording in `folder`, which is made if need be. What a writer that was killed has left there is taken away.
    ///
    /// # Errors
    /// The folder cannot be made or written, another writer is at it, or `existing` forbids it.
    pub fn create(
        folder: impl AsRef<Path>,
        meta: &Meta,
        existing: Existing,
    ) -> Result<Self, Error> {
        Self::create_logging(folder, meta, existing, &[])
    }

    /// The same with quantities beside the layout's columns: `aux_` and a name each ([`Samples::logged`]).
    ///
    /// # Errors
    /// As [`Writer::create`].
    pub fn create_logging(
        folder: impl AsRef<Path>,
        meta: &Meta,
        existing: Existing,
        logged: &[&str],
    ) -> Result<Self, Error> {
        let folder = folder.as_ref().to_owned();
        check_existing(&folder, existing, None)?;
        let created = !folder.exists();
        std::fs::create_dir_all(&folder)
            .map_err(|error| Error::io(&folder, &error, "a folder to write into"))?;
        let mut writer = Self::new(folder, created, meta);
        let file = locked_file(&writer.folder)
            .map_err(|error| Error::io(&writer.folder, &error, "a folder to write into"))?;
        check_existing(&writer.folder, existing, Some(file.path()))?;
        let mut rows = csv::WriterBuilder::new()
            .buffer_capacity(1 << 16)
            .from_writer(file);
        let names = COLUMNS.iter().map(|(_, name)| *name);
        let header = names.clone().take(1).chain(["run"]).chain(names.skip(1));
        let header = header.chain(logged.iter().copied());
        rows.write_record(header)
            .map_err(|error| writer.failed(&error.into()))?;
        writer.rows = Some(Rows::Csv(Box::new(rows)));
        Ok(writer)
    }

    /// Begins a recording in one file: its rows are kept in memory, and `write` writes them when it is finished. Errors count rows from 1.
    #[must_use]
    pub fn keeping(
        file: impl AsRef<Path>,
        meta: &Meta,
        existing: Existing,
        logged: &[&str],
        write: WriteFile,
    ) -> Self {
        let mut writer = Self::new(file.as_ref().to_owned(), false, meta);
        let named = |name: &&str| Logged {
            name: (*name).to_owned(),
            values: Vec::new(),
        };
        writer.rows = Some(Rows::Kept {
            samples: Box::default(),
            logged: logged.iter().map(named).collect(),
            existing,
            write,
        });
        writer
    }

    fn new(folder: PathBuf, created: bool, meta: &Meta) -> Self {
        Self {
            created,
            finished: false,
            meta: meta.clone(),
            limits: meta.count_limits(),
            rows: None,
            line: 1,
            last_time_s: f64::NEG_INFINITY,
            seen: Samples::default(),
            seen_columns: [false; COLUMNS.len()],
            folder,
        }
    }

    /// The table of units, which is written last: noise that is measured while recording may still be entered. The
    /// ranges of counts are those that were given at first.
    pub fn meta_mut(&mut self) -> &mut Meta {
        &mut self.meta
    }

    /// Appends a sample.
    ///
    /// # Errors
    /// A value that the reader would refuse, or a failure to write.
    pub fn push(&mut self, row: &Row) -> Result<(), Error> {
        self.push_logging(row, &[])
    }

    /// The same with one value, or NaN, for each quantity beside the layout's columns.
    ///
    /// # Errors
    /// As [`Writer::push`].
    pub fn push_logging(&mut self, row: &Row, logged: &[f64]) -> Result<(), Error> {
        self.line += 1;
        self.check(row)?;
        for (place, (column, _)) in COLUMNS.iter().enumerate() {
            self.seen_columns[place] |= !row.get(*column).is_nan();
        }
        let written = match self.rows.as_mut() {
            Some(Rows::Csv(rows)) => rows.write_record(fields(row, logged)),
            Some(Rows::Kept {
                samples,
                logged: kept,
                ..
            }) => {
                samples.push(row);
                for (place, one) in kept.iter_mut().enumerate() {
                    let value = logged.get(place).copied();
                    one.values.push(value.unwrap_or(f64::NAN));
                }
                Ok(())
            }
            None => Ok(()),
        };
        written.map_err(|error| self.failed(&error.into()))
    }

    /// Checks the whole and puts it in place.
    ///
    /// # Errors
    /// No samples, a table without what the columns need, or a failure to write.
    pub fn finish(mut self) -> Result<(), Error> {
        let samples_file = self.table();
        if self.line == 1 {
            return Err(Error::new(&samples_file, "no samples", "at least one"));
        }
        for (place, seen) in self.seen_columns.iter().enumerate() {
            self.seen
                .set_next(place, if *seen { 0.0 } else { f64::NAN });
        }
        self.seen.end_row("");
        let meta_file = self.folder.join(META_FILE);
        self.meta.check_against(&meta_file, &self.seen)?;
        let text = self.meta.to_toml();
        Meta::parse(&meta_file, &text, &mut Vec::new())?;
        match self.rows.take() {
            Some(Rows::Csv(rows)) => self.put_in_place(*rows, &text)?,
            Some(Rows::Kept {
                mut samples,
                logged,
                existing,
                write,
            }) => {
                logged.into_iter().for_each(|logged| samples.log(logged));
                write(&self.meta, &samples, &self.folder, existing)?;
            }
            None => {}
        }
        self.finished = true;
        Ok(())
    }

    /// Moves both files of a folder to their places.
    fn put_in_place(&self, rows: csv::Writer<NamedTempFile>, meta_text: &str) -> Result<(), Error> {
        let failed = |error: std::io::Error| Error::io(&self.folder, &error, "room to write");
        let mut meta = unfinished_file(&self.folder).map_err(failed)?;
        meta.write_all(meta_text.as_bytes())
            .and_then(|()| meta.as_file().sync_all())
            .map_err(failed)?;
        let samples = rows
            .into_inner()
            .map_err(|error| failed(error.into_error()))?;
        samples.as_file().sync_all().map_err(failed)?;
        persist(samples, &self.folder.join(SAMPLES_FILE))?;
        persist(meta, &self.folder.join(META_FILE))
    }

    /// The file that errors of a row name.
    fn table(&self) -> PathBuf {
        match self.rows {
            Some(Rows::Kept { .. }) => self.folder.clone(),
            _ => self.folder.join(SAMPLES_FILE),
        }
    }

    fn failed(&self, error: &std::io::Error) -> Error {
        Error::io(&self.table(), error, "room to write")
    }

    fn check(&mut self, row: &Row) -> Result<(), Error> {
        let file = self.table();
        let line = self.line - u64::from(matches!(self.rows, Some(Rows::Kept { .. })));
        check_row(&file, line, row, &self.limits, self.last_time_s)?;
        self.last_time_s = row.t_s;
        Ok(())
    }
}

/// Refuses in one row what the reader would.
fn check_row(
    file: &Path,
    line: u64,
    row: &Row,
    limits: &CountLimits,
    last_time_s: f64,
) -> Result<(), Error> {
    let refuse = |found: String, wanted: String, column: Column| {
        Err(Error::new(file, found, wanted)
            .row(line)
            .column(column.name()))
    };
    for (column, _) in COLUMNS {
        let value = row.get(column);
        if value.is_nan() && !given(row, column) {
            continue;
        }
        if let Err(wanted) = column.check(value, limits) {
            return refuse(value.to_string(), wanted, column);
        }
    }
    if row.t_s <= last_time_s {
        let wanted = format!("a time after the row before, {last_time_s} s");
        return refuse(row.t_s.to_string(), wanted, Column::Time);
    }
    if row.run.trim() != row.run || row.run.contains(char::is_control) {
        let found = excerpt(row.run.as_bytes());
        return Err(Error::new(file, found, "a name on one line")
            .row(line)
            .column("run"));
    }
    Ok(())
}

/// Refuses in a whole recording what the reader would.
pub(crate) fn check(meta: &Meta, samples: &Samples, file: &Path) -> Result<(), Error> {
    if samples.is_empty() {
        return Err(Error::new(file, "no samples", "at least one"));
    }
    let limits = meta.count_limits();
    let mut last_time_s = f64::NEG_INFINITY;
    for index in 0..samples.len() {
        let row = samples.row(index);
        check_row(file, 2 + index as u64, &row, &limits, last_time_s)?;
        last_time_s = row.t_s;
    }
    meta.check_against(Path::new(META_FILE), samples)?;
    Meta::parse(Path::new(META_FILE), &meta.to_toml(), &mut Vec::new()).map(drop)
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.rows = None;
        if self.created && !self.finished {
            // Only ever an empty folder of this writer's own making; anything else stays.
            let _ = std::fs::remove_dir(&self.folder);
        }
    }
}

/// True if the caller gave a value for this column, NaN included.
fn given(row: &Row, column: Column) -> bool {
    match column {
        Column::Time => true,
        Column::Sine(segment) | Column::Cosine(segment) => row.quadrature_counts[segment].is_some(),
        Column::Teeth(segment) => row.teeth[segment].is_some(),
        Column::Position(segment) => row.position_m[segment].is_some(),
        Column::Electrode(_) => row.electrode_counts.is_some(),
        Column::Temperature => row.temperature_c.is_some(),
        Column::Commanded(axis) => row.commanded[axis].is_some(),
        Column::Reference(axis) => row.reference[axis].is_some(),
    }
}

/// The fields of one row of `samples.csv`.
fn fields(row: &Row, logged: &[f64]) -> Vec<String> {
    let mut fields: Vec<String> = Vec::with_capacity(COLUMNS.len() + 1);
    fields.extend(COLUMNS.iter().map(|(column, _)| number(row.get(*column))));
    fields.insert(1, row.run.to_owned());
    fields.extend(logged.iter().map(|value| number(*value)));
    fields
}

/// Shortest text that reads back to the same number; empty for NaN.
fn number(value: f64) -> String {
    if value.is_nan() {
        String::new()
    } else if value.fract() == 0.0
        && value.abs() < 1e15
        && (value != 0.0 || value.is_sign_positive())
    {
        format!("{value}")
    } else {
        format!("{value:?}")
    }
}

fn persist(file: NamedTempFile, place: &Path) -> Result<(), Error> {
    file.persist(place)
        .map(drop)
        .map_err(|error| Error::io(place, &error.error, "room to write"))
}
