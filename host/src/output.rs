//! Files that commands write: whole or not at all.

use anyhow::{Context, Result};
use std::io::Write as _;
use std::path::Path;

/// Writes `bytes` beside `path` and moves them into place, so that a failure leaves what was there.
///
/// # Errors
/// The folder is missing, full or not writable.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let told = || {
        format!(
            "{}: a file in a folder that can be written was wanted",
            path.display()
        )
    };
    let mut file = tempfile::NamedTempFile::new_in(folder).with_context(told)?;
    file.write_all(bytes).with_context(told)?;
    file.persist(path).with_context(told)?;
    Ok(())
}
