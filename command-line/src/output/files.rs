//! What a command reads and writes, checked before it does anything.

use super::check_folder_of;
use super::kind::Kind;
use super::same::{same, within};
use crate::json::Json;
use anyhow::{Result, bail, ensure};
use recording::{META_FILE, SAMPLES_FILE};
use std::path::{Path, PathBuf};

/// The files that a command line names.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// Files that are read.
    inputs: Vec<PathBuf>,
    /// Files that are written.
    outputs: Vec<Output>,
    /// Folders that are filled.
    folders: Vec<PathBuf>,
}

#[derive(Clone, Debug)]
struct Output {
    path: PathBuf,
    kind: Kind,
    /// Whether it may replace a file of its kind.
    replaces: bool,
}

impl Files {
    /// A file that is read.
    #[must_use]
    pub fn reads(mut self, path: &Path) -> Self {
        self.inputs.push(path.to_owned());
        self
    }

    /// A recording that is read.
    #[must_use]
    pub fn reads_recording(self, folder: &Path) -> Self {
        self.reads(folder)
            .reads(&folder.join(META_FILE))
            .reads(&folder.join(SAMPLES_FILE))
    }

    /// A folder that is filled, and perhaps emptied before.
    #[must_use]
    pub fn fills(mut self, folder: &Path) -> Self {
        self.folders.push(folder.to_owned());
        self
    }

    /// A file that is written, and replaces one of its kind; `-` is standard output.
    #[must_use]
    pub fn writes(self, path: Option<&PathBuf>, kind: Kind) -> Self {
        self.output(path, kind, true)
    }

    /// As [`Files::writes`], where a file that is there is replaced only with `force`.
    #[must_use]
    pub fn writes_new(self, path: Option<&PathBuf>, kind: Kind, force: bool) -> Self {
        self.output(path, kind, force)
    }

    /// The file of a `--json`.
    #[must_use]
    pub fn json(self, json: &Json, kind: Kind) -> Self {
        self.output(json.file(), kind, true)
    }

    fn output(mut self, path: Option<&PathBuf>, kind: Kind, replaces: bool) -> Self {
        let path = path.filter(|path| path.as_os_str() != "-").cloned();
        self.outputs.extend(path.map(|path| Output {
            path,
            kind,
            replaces,
        }));
        self
    }

    /// Refuses what would lose something: an output over an input, over another output, over a file of another kind, in a folder
    /// that is filled, or where no file can be.
    ///
    /// # Errors
    /// The first that would.
    pub fn check(&self) -> Result<()> {
        for (place, output) in self.outputs.iter().enumerate() {
            let path = &output.path;
            check_folder_of(path)?;
            let told = path.display();
            if self.inputs.iter().any(|input| same(input, path)) {
                bail!("{told}: found a file that this command reads, wanted another one to write");
            }
            let others = &self.outputs[..place];
            if others.iter().any(|other| same(&other.path, path)) {
                bail!("{told}: found two outputs in one file, wanted a file for each");
            }
            if self.folders.iter().any(|folder| within(path, folder)) {
                bail!(
                    "{told}: found a file in the folder that this command fills, wanted one elsewhere"
                );
            }
            let there = path.exists();
            ensure!(
                output.replaces || !there,
                "{told}: found a file, wanted a new one, or --force"
            );
            output.kind.check(path)?;
        }
        Ok(())
    }
}
