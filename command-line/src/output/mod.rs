//! Files that commands write: [`Files`] says which ones and refuses before any work what would lose something, [`Kind`] says by its
//! content what a file is, `replace` writes whole or not at all.

mod files;
mod kind;
mod replace;
mod same;

pub use files::Files;
pub use kind::Kind;
pub use replace::{check_folder_of, new_file, replace_file};

use anyhow::Result;
use std::path::Path;

/// Writes a file of this kind. What is there already is replaced only where it is of the same kind.
///
/// # Errors
/// A file of another kind is there, or the folder is missing, full or not writable.
pub fn write(path: &Path, kind: Kind, bytes: &[u8]) -> Result<()> {
    kind.check(path)?;
    replace_file(path, bytes)
}
