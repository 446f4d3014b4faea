//! Files that are there only once they are whole.

use std::io::Result;
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// A file without a name of its own yet in `folder`: it vanishes unless it is moved to one. Whoever may read any file
/// that the user makes may read it (temporary files are private to their maker otherwise).
///
/// # Errors
/// The folder is missing, full or not writable.
pub fn unfinished_file(folder: &Path) -> Result<NamedTempFile> {
    #[allow(unused_mut)] // where there are no modes
    let mut builder = Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask
    builder.tempfile_in(folder)
}
