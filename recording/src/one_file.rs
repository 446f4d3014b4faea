//! A recording as one file: where it may be written, and how it comes there whole or not at all.

use crate::error::Error;
use crate::existing::Existing;
use crate::unfinished::unfinished_file;
use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

/// Refuses a file that `existing` forbids to replace, and a place where no file can be. `is_recording` says whether a file is one.
///
/// # Errors
/// Something else than a recording is there, or there is anything and nothing may be replaced.
pub fn check_existing_file(
    path: &Path,
    existing: Existing,
    is_recording: impl Fn(&Path) -> bool,
) -> Result<(), Error> {
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

/// Writes a file by `fill`, which says what went wrong. It is at its place once it is whole, in place of another if `replace`.
///
/// # Errors
/// A failure to write, or another file is there by then; nothing is left behind.
pub fn write_file(
    path: &Path,
    replace: bool,
    fill: impl FnOnce(File) -> Result<(), String>,
) -> Result<(), Error> {
    let failed = |found: String| Error::new(path, found, "room to write");
    let of_system = |error: std::io::Error| failed(error.to_string());
    let file = unfinished_file(folder_of(path)).map_err(of_system)?;
    let written = file.as_file().try_clone().map_err(of_system)?;
    fill(written).map_err(failed)?;
    file.as_file().sync_all().map_err(of_system)?;
    let placed = match replace {
        true => file.persist(path),
        false => file.persist_noclobber(path),
    };
    placed.map(drop).map_err(|error| match error.error.kind() {
        ErrorKind::AlreadyExists => Error::new(path, "a file", "a new file"),
        _ => of_system(error.error),
    })
}

fn folder_of(path: &Path) -> &Path {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}
