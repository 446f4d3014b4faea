//! What may be replaced in a folder that is already there.

use crate::error::{Error, one_line};
use crate::layout::{META_FILE, SAMPLES_FILE};
use crate::meta::Meta;
use crate::unfinished::{Left, examine};
use std::io::ErrorKind;
use std::path::Path;

/// What [`crate::Writer::create`] does with a folder that is already there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Nothing but an empty folder is written into.
    Refuse,
    /// A recording of this schema, and nothing beside it, is replaced when the new one is finished.
    ReplaceRecording,
}

/// Refuses a folder that `existing` forbids; what a killed writer has left in it is taken away. `own` is the caller's unfinished
/// recording. A writer asks before it makes one and again once it is locked: of two that begin at once, at least one sees the other.
pub(crate) fn check_existing(
    folder: &Path,
    existing: Existing,
    own: Option<&Path>,
) -> Result<(), Error> {
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
        if own.and_then(Path::file_name) == Some(name.as_os_str()) {
            continue;
        }
        match examine(folder, &name) {
            Left::Abandoned(file) => abandoned.push((folder.join(&name), file)),
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
    for (path, locked) in abandoned {
        match std::fs::remove_file(&path) {
            // Another writer found it as abandoned as this one did.
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            removed => removed.map_err(|error| Error::io(&path, &error, wanted))?,
        }
        drop(locked);
    }
    Ok(())
}
