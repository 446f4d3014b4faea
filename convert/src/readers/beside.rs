//! What readers have in common: what a log needs beside itself, and a look at its first lines.

use crate::source::{Asked, Target};
use recording::Column;
use std::path::PathBuf;

/// What a log needs to be read and does not say itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beside {
    /// A DBC file and its text: which bits of which frame are which signal.
    pub dbc: Option<(PathBuf, String)>,
    /// Of several kinds of messages the one that makes the rows; the others are interpolated to its times.
    pub rows_of: Option<String>,
    /// What was asked for as a sensor's output, as `--column` says it: without `rows_of` its messages make the rows.
    pub sensor: Option<String>,
}

impl Beside {
    /// Of the columns that were asked for the source of the first that is a sensor's output.
    #[must_use]
    pub fn sensor_of(asked: &[Asked]) -> Option<String> {
        let is_output = |asked: &&Asked| {
            matches!(
                asked.target,
                Target::Numbers(Column::Sine(_) | Column::Cosine(_) | Column::Position(_))
            )
        };
        asked
            .iter()
            .find(is_output)
            .map(|asked| asked.source.clone())
    }
}

/// The first lines of a file, as far as they can be text: enough to tell who wrote it.
pub(super) fn first_lines(bytes: &[u8]) -> impl Iterator<Item = &str> {
    /// Lines of greeting that a program may write before its data: those of SimpleFOC's start are a dozen.
    const LOOKED_AT: usize = 60;
    let lines = bytes.split(|byte| *byte == b'\n').take(LOOKED_AT);
    lines
        .filter_map(|line| std::str::from_utf8(line).ok())
        .map(str::trim)
        .filter(|line| !line.is_empty())
}
