//! Reader and writer of recordings: a folder of `recording.toml` and `samples.csv`, schema 1.
//!
//! [`Recording::read`] checks everything that the layout promises, so that a reader of a [`Recording`] need not:
//! values are finite and in range, time strictly increases, the tables that the columns need are there.
//! [`Writer`] applies the same checks to each row and leaves nothing behind unless it is finished.
//! Not measured is NaN inside a column and `None` in a [`Row`].

mod column;
mod error;
mod foreign;
mod keys;
mod meta;
pub mod noise;
mod read;
mod rows;
mod samples;
mod unfinished;
mod write;

pub use column::{COLUMNS, Column};
pub use error::{Error, excerpt};
pub use meta::{Coordination, Electronics, Geometry, Meta};
pub use samples::{Logged, Row, Samples, unmodified_m};
pub use unfinished::unfinished_file;
pub use write::{Existing, Writer};

use std::path::Path;

/// Version of the layout that this library reads and writes.
pub const SCHEMA: i64 = 1;

/// Name of the table of units.
pub const META_FILE: &str = "recording.toml";

/// Name of the table of samples.
pub const SAMPLES_FILE: &str = "samples.csv";

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
        read::read(path.as_ref())
    }

    /// Checks what [`Recording::write`] would refuse in the values themselves; `file` is what errors name, with the header as row 1.
    ///
    /// # Errors
    /// As [`Writer::push`], and a table of units without what the columns need.
    pub fn check(&self, file: &Path) -> Result<(), Error> {
        write::check(self, file)
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
