//! What a file of the table says of its recording, so that its answer can be taken over under another path.

use diagnosis::verdict::answer::Diagnosis;
use std::path::Path;

/// Columns of a row that are read again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    recording: String,
    /// None of what could not be read or diagnosed: the line that says why has the path in it.
    answer: Option<String>,
}

impl Kept {
    /// Of a file; none where it has gone meanwhile, or is no row.
    #[must_use]
    pub fn read(file: &Path) -> Option<Self> {
        let text = texts(file)?;
        Some(Self {
            recording: text("recording")?,
            answer: text("answer"),
        })
    }

    /// The answer as it would be of the same recording at this path.
    #[must_use]
    pub fn answer(&self, path: &str) -> Option<Diagnosis> {
        let answer: Diagnosis = serde_json::from_str(self.answer.as_deref()?).ok()?;
        Some(Diagnosis {
            recording: path.to_owned(),
            ..answer
        })
    }

    /// True if the recording is no longer at its path, as far as its path is known: what is no Unicode was written otherwise.
    #[must_use]
    pub fn is_gone(&self) -> bool {
        let is_whole = !self.recording.contains(char::REPLACEMENT_CHARACTER);
        is_whole && !Path::new(&self.recording).exists()
    }
}

/// The texts of a file's row by the names of their columns.
#[cfg(not(feature = "parquet"))]
fn texts(file: &Path) -> Option<impl Fn(&str) -> Option<String>> {
    let line = std::fs::read_to_string(file).ok()?;
    let row: serde_json::Value = serde_json::from_str(&line).ok()?;
    Some(move |name: &str| Some(row[name].as_str()?.to_owned()))
}

#[cfg(feature = "parquet")]
fn texts(file: &Path) -> Option<impl Fn(&str) -> Option<String>> {
    let row = columnar::log(file).ok()?;
    Some(move |name: &str| {
        let column = row.columns.iter().find(|column| column.name == name)?;
        Some(column.words.first()?.1.clone())
    })
}
