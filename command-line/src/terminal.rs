//! What commands print with: text and JSON on standard output, tables, progress.

use anyhow::Result;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::Write as _;

/// Writes `text` and a line end to standard output.
///
/// # Errors
/// Standard output is closed or full.
pub fn print(text: &str) -> Result<()> {
    let mut output = std::io::stdout().lock();
    writeln!(output, "{text}")?;
    output.flush()?;
    Ok(())
}

/// Writes `value` as one JSON object to standard output.
///
/// # Errors
/// Standard output is closed or full.
pub fn print_json<T: Serialize>(value: &T) -> Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// One line on standard error that is not an error.
pub fn warn(text: &str) {
    eprintln!("courier: warning: {}", one_line(text));
}

/// `text` on one line: line ends and other control characters become spaces.
pub fn one_line(text: &str) -> String {
    text.trim()
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

/// A table with a header; all columns but the first are numbers and go to the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table
        .load_style(presets::ASCII_MARKDOWN)
        .set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.to_vec());
    for row in rows {
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

/// Names and values, one pair a line.
pub fn pairs(rows: &[(&str, String)]) -> String {
    let width = rows
        .iter()
        .map(|(name, _)| name.chars().count())
        .max()
        .unwrap_or(0);
    let lines: Vec<String> = rows
        .iter()
        .map(|(name, value)| format!("{name:width$}  {value}"))
        .collect();
    lines.join("\n")
}

/// A number with as many digits as tell something.
pub fn figure(value: f64) -> String {
    let digits = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.digits$}")
}

/// A length in micrometres.
pub fn micrometres(length_m: f64) -> String {
    figure(length_m * 1.0e6)
}

/// A progress bar on standard error; nothing where that is no terminal.
pub fn progress(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{prefix}{msg:28} {bar:40} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// Steps of a bar over stages.
const STEPS: u64 = 1000;

/// A progress bar over the stages of one piece of work on standard error; nothing where that is no terminal.
pub fn stages() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{msg:30} {bar:40} {percent} % {elapsed}") {
        bar.set_style(style);
    }
    bar
}

/// Tells a bar of [`stages`] the stage that begins, and the share of the work that is done. It never goes back.
pub fn begin(bar: &ProgressBar, what: &str, done: f64) {
    bar.set_message(what.to_owned());
    let steps = (done.clamp(0.0, 1.0) * STEPS as f64) as u64;
    bar.set_position(steps.max(bar.position()));
    // Long computations are silent in between.
    bar.tick();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_never_goes_back() {
        let bar = stages();
        begin(&bar, "one", 0.5);
        begin(&bar, "two", 0.2);
        assert_eq!(bar.position(), STEPS / 2);
        assert_eq!(bar.message(), "two");
    }

    #[test]
    fn a_message_is_one_line() {
        assert_eq!(one_line("a\r\nb\u{1b}[31m\n"), "a  b [31m");
    }
}
