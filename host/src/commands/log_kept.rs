//! `courier log --kept`: the board's story, as it lies in its flash.

use super::log_words as words;
use crate::board::{Choice, Link};
use crate::json::Json;
use crate::terminal::warn;
use anyhow::{Result, bail};
use courier_sensor::event_log::entry::{Event, LAYOUT, Read, decode};
use courier_sensor::event_log::page::Page;
use courier_sensor::link::message::{Action, Reply};
use serde::Serialize;
use std::process::ExitCode;

/// The log, as far as it could be read.
#[derive(Debug, Default)]
struct Story {
    entries: Vec<Read>,
    damaged_bytes: u16,
    /// Entries whose content could not be read.
    unreadable: usize,
}

/// One line of `--json`.
#[derive(Serialize)]
struct Line<'e> {
    level: &'static str,
    message: String,
    number: u32,
    start: u32,
    uptime_s: u32,
    unix_s: Option<u64>,
    event: Option<&'e Event>,
}

/// Reads, decodes, prints.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(json: &Json, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let story = read(&mut board.link)?;
    board.close()?;
    let mut lines = json.lines()?;
    for entry in &story.entries {
        let line = line(entry);
        lines.push(&line, || {
            format!("{}  {}", words::when(entry.head()), line.message)
        })?;
    }
    story.tell_what_is_left_out();
    Ok(ExitCode::SUCCESS)
}

fn read(link: &mut Link) -> Result<Story> {
    let (mut story, mut skip) = (Story::default(), 0);
    loop {
        let Reply::KeptLog(page) = link.ask(Action::KeptLog { skip })? else {
            bail!(super::STRANGE_REPLY)
        };
        skip += story.take(&page);
        if !page.more {
            // A cut can leave pages in another order.
            story.entries.sort_by_key(|entry| entry.head().number);
            return Ok(story);
        }
    }
}

impl Story {
    /// Takes a page; how many entries it held.
    fn take(&mut self, page: &Page) -> u16 {
        let before = self.entries.len() + self.unreadable;
        for entry in page.entries() {
            match decode(entry) {
                Some(entry) => self.entries.push(entry),
                None => self.unreadable += 1,
            }
        }
        self.damaged_bytes = page.damaged_bytes;
        (self.entries.len() + self.unreadable - before) as u16
    }

    fn tell_what_is_left_out(&self) {
        if self.entries.is_empty() {
            warn(
                "the log: nothing is kept yet; a start is written after 10 s, after a fault at once",
            );
        }
        let others = self
            .entries
            .iter()
            .filter(|entry| matches!(entry, Read::Other { .. }))
            .count();
        if others > 0 {
            warn(&format!(
                "the log: found {others} entries of another firmware's layout, wanted {LAYOUT}: only their times are shown"
            ));
        }
        if self.unreadable > 0 || self.damaged_bytes > 0 {
            warn(&format!(
                "the log: skipped {} entries that cannot be read, and {} bytes of entries that were cut short or damaged",
                self.unreadable, self.damaged_bytes
            ));
        }
        let gaps: u32 = self
            .entries
            .windows(2)
            .map(|pair| gap(&pair[0], &pair[1]))
            .sum();
        if gaps > 0 {
            warn(&format!("the log: {gaps} entries between these are lost"));
        }
    }
}

/// Entries that are missing between two.
fn gap(before: &Read, after: &Read) -> u32 {
    (after.head().number - before.head().number).saturating_sub(1)
}

fn line(entry: &Read) -> Line<'_> {
    let head = entry.head();
    let (event, level, message) = match entry {
        Read::Known(_, event) => (Some(event), words::level(event), words::what(event)),
        Read::Other { layout, .. } => (
            None,
            "info",
            format!("an entry of another firmware, layout {layout}"),
        ),
    };
    Line {
        level,
        message,
        number: head.number,
        start: head.start,
        uptime_s: head.time.uptime_s,
        unix_s: head.time.unix_s,
        event,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::event_log::entry::{ENTRY_BYTES, Head, encode};

    #[test]
    fn what_cannot_be_read_is_counted_and_the_rest_is_shown() {
        let mut page = Page::default();
        let entry = |number| {
            let mut buffer = [0; ENTRY_BYTES];
            let head = Head {
                number,
                ..Head::default()
            };
            encode(&head, &Event::Status(1 << 19), &mut buffer)
                .unwrap()
                .to_vec()
        };
        let mut other = entry(3);
        other[0] = LAYOUT + 1;
        let mut cut = entry(4);
        cut.truncate(5);
        for bytes in [entry(1), other, cut, entry(7)] {
            assert!(page.add(&bytes));
        }
        let mut story = Story::default();
        assert_eq!(story.take(&page), 4);
        let lines: Vec<String> = story
            .entries
            .iter()
            .map(|entry| line(entry).message)
            .collect();
        assert_eq!(
            lines,
            [
                "converter does not answer",
                "an entry of another firmware, layout 2",
                "converter does not answer"
            ]
        );
        assert_eq!(story.unreadable, 1);
        assert_eq!(gap(&story.entries[1], &story.entries[2]), 3);
    }
}
