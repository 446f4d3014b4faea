//! A whole recording in memory.

use crate::error::Error;
use crate::existing::Existing;
use crate::meta::Meta;
use crate::read::read;
use crate::samples::{Row, Samples};
use crate::write::{Writer, check};
use std::path::Path;

/// A whole recording in memory: eight bytes a field of every column that holds anything.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// `recording.toml`.
    pub meta: Meta,
    /// `samples.csv`.
    pub samples: Samples,
    /// One line each: unknown columns and keys, counts that are not whole.
    pub warnings: Vec<String>,
}

impl Recording {
    /// Reads and checks the folder `path`.
    ///
    /// # Errors
    /// One [`Error`] for the first thing that is wrong, naming file, row and column.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let (meta, samples, warnings) = read(path.as_ref())?;
        Ok(Self {
            meta,
            samples,
            warnings,
        })
    }

    /// The same with each row changed; a row for which `change` is false is left out. It is told the row's number.
    #[must_use]
    pub fn with_rows(&self, mut change: impl FnMut(usize, &mut Row) -> bool) -> Self {
        let mut samples = Samples::default();
        for index in 0..self.samples.len() {
            let mut row = self.samples.row(index);
            if change(index, &mut row) {
                samples.push(&row);
            }
        }
        Self {
            samples,
            ..self.clone()
        }
    }

    /// Checks what [`Recording::write`] would refuse in the values themselves; `file` is what errors name, with the header as row 1.
    ///
    /// # Errors
    /// As [`Writer::push`], and a table of units without what the columns need.
    pub fn check(&self, file: &Path) -> Result<(), Error> {
        check(&self.meta, &self.samples, file)
    }

    /// Writes the whole recording into the folder `path`; `existing` says what may be replaced.
    ///
    /// # Errors
    /// As [`Writer::create`], [`Writer::push`] and [`Writer::finish`]; nothing is left behind.
    pub fn write(&self, path: impl AsRef<Path>, existing: Existing) -> Result<(), Error> {
        let logged = self.samples.logged();
        let names: Vec<&str> = logged.iter().map(|logged| logged.name.as_str()).collect();
        let mut writer = Writer::create_logging(path, &self.meta, existing, &names)?;
        for index in 0..self.samples.len() {
            let beside: Vec<f64> = logged.iter().map(|logged| logged.values[index]).collect();
            writer.push_logging(&self.samples.row(index), &beside)?;
        }
        writer.finish()
    }
}
