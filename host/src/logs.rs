//! Logs of other programs: texts, and Parquet files where this build has the feature.

use crate::recordings;
use anyhow::{Context, Result};
use convert::Log;
use std::path::Path;

/// Reads a log.
///
/// # Errors
/// It cannot be read, or is no table.
pub fn read(path: &Path) -> Result<Log> {
    if recordings::is_file(path) {
        return columns(path);
    }
    let bytes = std::fs::read(path).with_context(|| {
        format!(
            "{}: wanted a readable CSV file, or a recording",
            path.display()
        )
    })?;
    Ok(convert::read(path, &bytes)?)
}

#[cfg(feature = "parquet")]
fn columns(path: &Path) -> Result<Log> {
    Ok(columnar::log(path)?)
}

/// Such a file is taken for a recording, which this build does not read either.
#[cfg(not(feature = "parquet"))]
fn columns(path: &Path) -> Result<Log> {
    Err(recordings::read(path).err().map_or_else(
        || anyhow::anyhow!("{}: wanted a log", path.display()),
        Into::into,
    ))
}
