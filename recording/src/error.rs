//! The one error of this crate: where, what was found, what was wanted, in one line.

use std::fmt;
use std::path::{Path, PathBuf};

/// Longest excerpt of a file that an error quotes, characters.
const EXCERPT_CHARS: usize = 60;

/// Why a recording cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Error {
    /// The file or folder at fault.
    pub file: PathBuf,
    /// Line of the file, the header being 1, where a row is at fault.
    pub row: Option<u64>,
    /// Column of `samples.csv`, or key of `recording.toml` as `[table] key`.
    pub column: Option<String>,
    /// What is there.
    pub found: String,
    /// What should be there.
    pub wanted: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}:",
            one_line(&self.file.display().to_string(), usize::MAX)
        )?;
        if let Some(row) = self.row {
            write!(f, " row {row},")?;
        }
        if let Some(column) = &self.column {
            let kind = if column.starts_with('[') || !self.is_table() {
                "key"
            } else {
                "column"
            };
            write!(f, " {kind} {},", one_line(column, EXCERPT_CHARS))?;
        }
        write!(f, " found {}, wanted {}", self.found, self.wanted)
    }
}

impl Error {
    /// A table of samples, and no table of units.
    fn is_table(&self) -> bool {
        self.file
            .extension()
            .is_none_or(|extension| extension != "toml")
    }

    /// What was found in a file, and what was wanted.
    #[must_use]
    pub fn new(file: &Path, found: impl Into<String>, wanted: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            row: None,
            column: None,
            found: found.into(),
            wanted: wanted.into(),
        }
    }

    /// The same, of a line of the file.
    #[must_use]
    pub fn row(mut self, row: u64) -> Self {
        self.row = Some(row);
        self
    }

    /// The same, of a column or key.
    #[must_use]
    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into());
        self
    }

    pub(crate) fn io(file: &Path, error: &std::io::Error, wanted: &str) -> Self {
        let found = match error.kind() {
            std::io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => one_line(&error.to_string(), 2 * EXCERPT_CHARS),
        };
        Self::new(file, found, wanted)
    }
}

/// `bytes` as a short quoted excerpt without control characters, whatever they are.
#[must_use]
pub fn excerpt(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(4 * EXCERPT_CHARS)];
    match std::str::from_utf8(head) {
        Err(error) if error.error_len().is_some() => {
            format!(
                "\"{}\" (not UTF-8)",
                one_line(&String::from_utf8_lossy(head), EXCERPT_CHARS)
            )
        }
        _ => format!(
            "\"{}\"",
            one_line(&String::from_utf8_lossy(head), EXCERPT_CHARS)
        ),
    }
}

/// `text` without line breaks and other control characters, cut at `limit` characters.
pub(crate) fn one_line(text: &str, limit: usize) -> String {
    let clean = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut line: String = text.chars().take(limit).map(clean).collect();
    if text.chars().nth(limit).is_some() {
        line.push('…');
    }
    line
}
