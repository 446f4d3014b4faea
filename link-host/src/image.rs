//! Images as files: symbols that a host needs.

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol};
use std::path::Path;

/// Address of a symbol.
///
/// # Errors
/// The file is no image or has no such symbol.
pub fn symbol(image: &Path, name: &str) -> Result<u32> {
    let bytes = std::fs::read(image).with_context(|| image.display().to_string())?;
    let file = object::File::parse(&*bytes)
        .with_context(|| format!("{}: not an image", image.display()))?;
    let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
    let symbol = found.with_context(|| format!("{}: no symbol {name}", image.display()))?;
    Ok(symbol.address() as u32)
}
