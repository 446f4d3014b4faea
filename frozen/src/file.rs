//! Kept answers in a file: JSON, one line a specimen.

use crate::{Answer, Specimen};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A specimen and its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// What is diagnosed.
    pub specimen: Specimen,
    /// What was answered.
    pub answer: Answer,
}

/// Reads a file of kept answers.
///
/// # Errors
/// It cannot be read, or a line is no kept answer.
pub fn read(path: &Path) -> Result<Vec<Kept>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let lines = text.lines().enumerate();
    lines
        .map(|(k, line)| {
            serde_json::from_str(line)
                .with_context(|| format!("{}: line {}", path.display(), k + 1))
        })
        .collect()
}

/// Writes a file of kept answers.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, kept: &[Kept]) -> Result<()> {
    let mut text = String::new();
    for one in kept {
        text += &serde_json::to_string(one)?;
        text.push('\n');
    }
    std::fs::write(path, text).with_context(|| path.display().to_string())
}
