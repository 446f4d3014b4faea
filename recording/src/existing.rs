//! What may be replaced in a folder that is already there.

use crate::error::{Error, one_line};
use crate::layout::{META_FILE, SAMPLES_FILE};
use crate::meta::Meta;
use crate::unfinished::{Left, examine};
use std::path::Path;

/// What [`crate::Writer::create`] does with a folder that is already there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Nothing but an empty folder is written into.
    Refuse,
    /// A recording of this schema, and nothing beside it, is replaced when the new one is finished.
    ReplaceRecording,
}

/// Refuses a folder that `existing` forbids; what a killed writer has left in it is taken away.
pub(crate) fn check_existing(folder: &Path, existing: Existing) -> Result<(), Error> {
    if !folder.exists() {
        return Ok(());
    }
    let wanted = match existing {
        Existing::Refuse => "a new or an empty folder",
        Existing::ReplaceRecording => {
            "a new or an empty folder, or one with a recording of schema 1 alone"
        }
    };
    if !folder.is_dir() {
        return Err(Error::new(folder, "a file", wanted));
    }
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error, wanted))?;
    let (mut ours, mut abandoned) = (false, Vec::new());
    for entry in entries {
        let name = entry
            .map_err(|error| Error::io(folder, &error, wanted))?
            .file_name();
        match examine(folder, &name) {
            Left::Abandoned => abandoned.push(folder.join(&name)),
            Left::UnderWay => {
                let found = "a recording that another command is writing";
                return Err(Error::new(folder, found, wanted));
            }
            Left::Other => {
                let known = name == META_FILE || name == SAMPLES_FILE;
                if existing == Existing::Refuse || !known {
                    return Err(Error::new(
                        folder,
                        format!("\"{}\" in it", one_line(&name.to_string_lossy(), 60)),
                        wanted,
                    ));
                }
                ours = true;
            }
        }
    }
    if ours {
        let file = folder.join(META_FILE);
        let text =
            std::fs::read_to_string(&file).map_err(|error| Error::io(&file, &error, wanted))?;
        Meta::parse(&file, &text, &mut Vec::new())?;
    }
    // Only once nothing stands in the way any more.
    for file in abandoned {
        std::fs::remove_file(&file).map_err(|error| Error::io(&file, &error, wanted))?;
    }
    Ok(())
}
