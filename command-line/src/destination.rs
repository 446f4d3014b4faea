//! Where a command's recording goes.

use anyhow::{Result, anyhow};
use recording::{Existing, Meta, Writer};
use std::path::PathBuf;

/// A folder for a recording.
#[derive(Clone, Debug)]
pub struct Destination {
    /// The folder, which is made if need be.
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

    /// The same with quantities beside the layout's columns: `aux_` and a name each.
    ///
    /// # Errors
    /// As [`Destination::create`].
    pub fn create_logging(&self, meta: &Meta, logged: &[&str]) -> Result<Writer> {
        let existing = if self.force {
            Existing::ReplaceRecording
        } else {
            Existing::Refuse
        };
        Writer::create_logging(&self.folder, meta, existing, logged).map_err(|error| {
            let hint = if self.force {
                ""
            } else {
                "; --force replaces a recording"
            };
            anyhow!("{error}{hint}")
        })
    }
}
