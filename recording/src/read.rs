//! Reading a recording: every field is checked, memory is bounded by the values and not by the text.

use crate::column::{COLUMNS, COUNT, Column, CountLimits, is_logged};
use crate::error::{Error, excerpt, one_line};
use crate::foreign::{foreign_header, warn_of_unknown};
use crate::layout::{META_FILE, SAMPLES_FILE};
use crate::meta::Meta;
use crate::rows::{Fields, Rows};
use crate::samples::{Logged, Samples};
use crate::together::lack;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A `recording.toml` is a page of text.
const META_LIMIT_BYTES: u64 = 1 << 20;
const CHUNK_BYTES: usize = 1 << 16;

/// The table of units, the samples and the warnings of a folder.
pub(crate) fn read(folder: &Path) -> Result<(Meta, Samples, Vec<String>), Error> {
    match std::fs::metadata(folder) {
        Err(error) => {
            return Err(Error::io(
                folder,
                &error,
                "a folder with recording.toml and samples.csv",
            ));
        }
        Ok(data) if !data.is_dir() => {
            return Err(Error::new(
                folder,
                "a file",
                "a folder with recording.toml and samples.csv",
            ));
        }
        Ok(_) => {}
    }
    let mut warnings = Vec::new();
    let meta_file = folder.join(META_FILE);
    let meta = Meta::parse(&meta_file, &read_meta(&meta_file)?, &mut warnings)?;
    let samples_file = folder.join(SAMPLES_FILE);
    let samples = Table::new(&samples_file, meta.count_limits()).read(&mut warnings)?;
    meta.check_against(&meta_file, &samples)?;
    Ok((meta, samples, warnings))
}

fn open(file: &Path) -> Result<File, Error> {
    let opened = File::open(file).map_err(|error| Error::io(file, &error, "a readable file"))?;
    let data = opened
        .metadata()
        .map_err(|error| Error::io(file, &error, "a readable file"))?;
    if data.is_file() {
        Ok(opened)
    } else {
        Err(Error::new(file, "no regular file", "a readable file"))
    }
}

fn read_meta(file: &Path) -> Result<String, Error> {
    let mut bytes = Vec::new();
    let mut reader = open(file)?.take(META_LIMIT_BYTES + 1);
    reader
        .read_to_end(&mut bytes)
        .map_err(|error| Error::io(file, &error, "a readable file"))?;
    if bytes.len() as u64 > META_LIMIT_BYTES {
        return Err(Error::new(
            file,
            format!("more than {META_LIMIT_BYTES} bytes"),
            "a page of TOML",
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let row = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()]
            .iter()
            .filter(|byte| **byte == b'\n')
            .count();
        Error::new(file, "bytes that are not UTF-8", "TOML in UTF-8").row(row as u64)
    })
}

/// What a field of the file is for.
#[derive(Clone, Copy)]
enum Field {
    Number(Column),
    Run,
    /// A quantity beside the layout's: its place among those.
    Logged(usize),
    Unknown,
}

/// `samples.csv` while it is read.
struct Table<'a> {
    file: &'a Path,
    limits: CountLimits,
    fields: Vec<Field>,
    samples: Samples,
    last_time_s: f64,
    /// First row in which a column holds a count that is not whole.
    fractional: [Option<u64>; COUNT],
    logged: Vec<Logged>,
}

impl<'a> Table<'a> {
    fn new(file: &'a Path, limits: CountLimits) -> Self {
        Self {
            file,
            limits,
            fields: Vec::new(),
            samples: Samples::default(),
            last_time_s: f64::NEG_INFINITY,
            fractional: [None; COUNT],
            logged: Vec::new(),
        }
    }

    fn error(&self, row: u64, found: impl Into<String>, wanted: impl Into<String>) -> Error {
        Error::new(self.file, found, wanted).row(row)
    }

    fn read(mut self, warnings: &mut Vec<String>) -> Result<Samples, Error> {
        let path = self.file;
        let mut file = open(path)?;
        let mut rows = Rows::new();
        let mut chunk = vec![0; CHUNK_BYTES];
        loop {
            let length = file
                .read(&mut chunk)
                .map_err(|error| Error::io(path, &error, "a readable file"))?;
            rows.feed(
                &chunk[..length],
                |row, line| self.row(row, line, warnings),
                path,
            )?;
            if length == 0 {
                break;
            }
        }
        if self.fields.is_empty() {
            return Err(Error::new(
                self.file,
                "an empty file",
                "a header row and samples",
            ));
        }
        if self.samples.is_empty() {
            return Err(Error::new(
                self.file,
                "no samples",
                "at least one row after the header",
            ));
        }
        self.check_columns()?;
        for (place, row) in self.fractional.iter().enumerate() {
            if let Some(row) = row {
                let name = COLUMNS[place].1;
                warnings.push(format!("{SAMPLES_FILE}: column {name} holds counts that are not whole, first in row {row}"));
            }
        }
        for logged in self.logged {
            self.samples.log(logged);
        }
        Ok(self.samples)
    }

    fn row(&mut self, row: Fields, line: u64, warnings: &mut Vec<String>) -> Result<(), Error> {
        if self.fields.is_empty() {
            self.header(row, line, warnings)
        } else {
            self.sample(row, line)
        }
    }

    fn header(&mut self, row: Fields, line: u64, warnings: &mut Vec<String>) -> Result<(), Error> {
        let mut unknown = Vec::new();
        let mut names: Vec<&[u8]> = Vec::new();
        for (place, bytes) in row.iter().enumerate() {
            let bytes = if place == 0 {
                bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
            } else {
                bytes
            };
            let bytes = bytes.trim_ascii();
            let text = std::str::from_utf8(bytes)
                .map_err(|_| self.error(line, excerpt(bytes), "names of columns in UTF-8"))?;
            let field = match text {
                "run" => Field::Run,
                _ if is_logged(text) => {
                    self.logged.push(Logged {
                        name: text.to_owned(),
                        values: Vec::new(),
                    });
                    Field::Logged(self.logged.len() - 1)
                }
                _ => Column::by_name(text).map_or(Field::Unknown, Field::Number),
            };
            if matches!(field, Field::Unknown) {
                unknown.push(one_line(text, 60));
            } else if names.contains(&bytes) {
                return Err(self
                    .error(line, "the name a second time", "each column once")
                    .column(text));
            }
            names.push(bytes);
            self.fields.push(field);
        }
        let texts = names.iter().map(|name| std::str::from_utf8(name));
        if let Some((found, wanted)) = foreign_header(&texts.flatten().collect::<Vec<_>>()) {
            return Err(self.error(line, found, wanted));
        }
        warn_of_unknown(SAMPLES_FILE, &unknown, warnings);
        self.check_header(line)
    }

    /// Columns that make sense only together must be there together.
    fn check_header(&self, line: u64) -> Result<(), Error> {
        let has = |column: Column| {
            let is_it = |field: &Field| matches!(field, Field::Number(known) if *known == column);
            self.fields.iter().any(is_it)
        };
        let Some(lack) = lack(has) else {
            return Ok(());
        };
        let error = self.error(line, lack.found, lack.wanted);
        Err(match lack.column {
            Some(column) => error.column(column.name()),
            None => error,
        })
    }

    /// At least one segment has at least one output.
    fn check_columns(&self) -> Result<(), Error> {
        if (0..4).any(|segment| self.samples.has_segment(segment)) {
            return Ok(());
        }
        Err(Error::new(
            self.file,
            "no output of any segment",
            "counts with their tooth count, or positions",
        ))
    }

    fn sample(&mut self, row: Fields, line: u64) -> Result<(), Error> {
        if row.len() != self.fields.len() {
            let found = format!("{} fields", row.len());
            return Err(self.error(
                line,
                found,
                format!("{} as in the header", self.fields.len()),
            ));
        }
        let mut run = "";
        for (place, bytes) in row.iter().enumerate() {
            let bytes = bytes.trim_ascii();
            match self.fields[place] {
                Field::Unknown => {}
                Field::Run => {
                    run = std::str::from_utf8(bytes).map_err(|_| {
                        self.error(line, excerpt(bytes), "a name in UTF-8")
                            .column("run")
                    })?;
                }
                Field::Number(column) => self.number(column, bytes, line)?,
                Field::Logged(index) => self.logged_number(index, bytes, line)?,
            }
        }
        self.samples.end_row(run);
        Ok(())
    }

    fn number(&mut self, column: Column, bytes: &[u8], line: u64) -> Result<(), Error> {
        if bytes.is_empty() {
            if column == Column::Time {
                return Err(self
                    .error(line, "an empty field", "a time in every row, s")
                    .column(column.name()));
            }
            return Ok(());
        }
        let value = std::str::from_utf8(bytes)
            .ok()
            .and_then(|text| text.parse::<f64>().ok())
            .ok_or_else(|| {
                self.error(line, excerpt(bytes), "a number")
                    .column(column.name())
            })?;
        if let Err(wanted) = column.check(value, &self.limits) {
            return Err(self
                .error(line, excerpt(bytes), wanted)
                .column(column.name()));
        }
        if column == Column::Time {
            self.check_time(value, bytes, line)?;
        }
        if column.is_count() && value.fract() != 0.0 {
            self.fractional[column.index()].get_or_insert(line);
        }
        self.samples.set_next(column.index(), value);
        Ok(())
    }

    /// A quantity beside the layout's: any finite number.
    fn logged_number(&mut self, index: usize, bytes: &[u8], line: u64) -> Result<(), Error> {
        let text = std::str::from_utf8(bytes).ok();
        let value = match text {
            Some("") => Some(f64::NAN),
            _ => text
                .and_then(|text| text.parse::<f64>().ok())
                .filter(|value| value.is_finite()),
        };
        let Some(value) = value else {
            let name = self.logged[index].name.clone();
            return Err(self
                .error(line, excerpt(bytes), "a finite number")
                .column(&name));
        };
        self.logged[index].values.push(value);
        Ok(())
    }

    fn check_time(&mut self, time_s: f64, bytes: &[u8], line: u64) -> Result<(), Error> {
        if time_s <= self.last_time_s {
            let wanted = format!("a time after the row before, {} s", self.last_time_s);
            return Err(self
                .error(line, excerpt(bytes), wanted)
                .column(Column::Time.name()));
        }
        self.last_time_s = time_s;
        Ok(())
    }
}
