//! Files that are there only once they are whole, and what is left of those that were never finished.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Result};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// How the name of a recording begins that is not finished yet.
const PREFIX: &str = ".courier-unfinished-";

/// A file without a name of its own yet in `folder`: it vanishes unless it is moved to one. Whoever may read any file
/// that the user makes may read it (temporary files are private to their maker otherwise).
///
/// # Errors
/// The folder is missing, full or not writable.
pub fn unfinished_file(folder: &Path) -> Result<NamedTempFile> {
    #[allow(unused_mut)] // where there are no modes
    let mut builder = Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask
    builder.tempfile_in(folder)
}

/// [`unfinished_file`], locked for as long as it is open: a writer that was killed leaves it unlocked, which tells the next one that it
/// may go.
///
/// # Errors
/// As [`unfinished_file`], or the folder's file system has no locks.
pub(crate) fn locked_file(folder: &Path) -> Result<NamedTempFile> {
    loop {
        let file = unfinished_file(folder)?;
        file.as_file().lock()?;
        // Until it was locked, it looked like one whose writer is gone, and another writer may have taken it away.
        if file.path().exists() {
            return Ok(file);
        }
    }
}

/// What a name in a folder of recordings stands for.
#[derive(Debug)]
pub(crate) enum Left {
    /// Something else than an unfinished recording.
    Other,
    /// An unfinished recording whose writer is gone. The file is locked until this is dropped.
    Abandoned(File),
    /// An unfinished recording that is being written, or was a moment ago.
    UnderWay,
}

/// Whether `name` in `folder` is an unfinished recording, and whether somebody is still at it.
pub(crate) fn examine(folder: &Path, name: &OsStr) -> Left {
    if !name.to_string_lossy().starts_with(PREFIX) {
        return Left::Other;
    }
    let file = match OpenOptions::new().write(true).open(folder.join(name)) {
        Ok(file) => file,
        // Its writer has just moved it to its place or taken it away.
        Err(error) if error.kind() == ErrorKind::NotFound => return Left::UnderWay,
        // It is not ours to open.
        Err(_) => return Left::Other,
    };
    match file.try_lock() {
        Ok(()) => Left::Abandoned(file),
        Err(TryLockError::WouldBlock) => Left::UnderWay,
        Err(TryLockError::Error(_)) => Left::Other,
    }
}
