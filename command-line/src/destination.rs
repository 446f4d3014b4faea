//! Where a command's recording goes: into a folder, or into one file.

use crate::recordings;
use anyhow::{Result, anyhow};
use recording::{Error, Existing, Meta, Recording, Writer};
use std::path::PathBuf;

/// A place for a recording.
#[derive(Clone, Debug)]
pub struct Destination {
    /// The folder, which is made if need be, or a file whose name ends in `.parquet` or `.mcap`.
    pub folder: PathBuf,
    /// Whether a recording that is in it is replaced.
    pub force: bool,
}

impl Destination {
    /// Begins a recording there. What was there stays until the new one is finished.
    ///
    /// # Errors
    /// The folder cannot be written or holds something.
    pub fn create(&self, meta: &Meta) -> Result<Writer> {
        self.create_logging(meta, &[])
    }

    /// Writes a whole recording there.
    ///
    /// # Errors
    /// As [`Destination::create`], or a failure to write; nothing is left behind.
    pub fn write(&self, recording: &Recording) -> Result<()> {
        let logged = recording.samples.logged();
        let names: Vec<&str> = logged.iter().map(|logged| logged.name.as_str()).collect();
        let mut writer = self.create_logging(&recording.meta, &names)?;
        for index in 0..recording.samples.len() {
            let beside: Vec<f64> = logged.iter().map(|logged| logged.values[index]).collect();
            writer.push_logging(&recording.samples.row(index), &beside)?;
        }
        Ok(writer.finish()?)
    }

    /// The same with quantities beside the layout's columns: `aux_` and a name each.
    ///
    /// # Errors
    /// As [`Destination::create`].
    pub fn create_logging(&self, meta: &Meta, logged: &[&str]) -> Result<Writer> {
        let existing = self.existing();
        let created = match recordings::form(&self.folder) {
            Some(form) => recordings::create(form, &self.folder, meta, existing, logged),
            None => Writer::create_logging(&self.folder, meta, existing, logged),
        };
        created.map_err(|error| self.with_hint(&error))
    }

    /// Writes a whole recording there as a Parquet file that takes less.
    ///
    /// # Errors
    /// As [`Destination::write`]; it is no Parquet file's name.
    pub fn write_compact(&self, recording: &Recording) -> Result<()> {
        let written = recordings::write_compact(&self.folder, recording, self.existing());
        written.map_err(|error| self.with_hint(&error))
    }

    fn existing(&self) -> Existing {
        match self.force {
            true => Existing::ReplaceRecording,
            false => Existing::Refuse,
        }
    }

    fn with_hint(&self, error: &Error) -> anyhow::Error {
        let hint = if self.force || !self.folder.exists() {
            ""
        } else {
            "; --force replaces a recording"
        };
        anyhow!("{error}{hint}")
    }
}
