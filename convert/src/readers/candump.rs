//! Frames of a CAN bus as `candump -l`, `candump -L` and `candump -ta` of can-utils write them, and python-can in their form.
//!
//! `(1764248400.000200) can0 18FEF1FE#0000001F40000000 R`, `##` and a digit of flags before the data of CAN FD, or
//! `(1764248400.000200)  can0  123   [8]  00 11 22 33 44 55 66 77`.

use super::beside::{Beside, first_lines};
use super::dbc::{self, Message};
use super::streams::{Stream, together};
use crate::table::{Log, LogColumn};
use crate::text::decode;
use recording::{Error, excerpt};
use std::collections::BTreeMap;
use std::path::Path;

/// Bit 31 of an identifier in a DBC file: it is one of 29 bits.
const EXTENDED: u32 = 1 << 31;
/// More kinds of frames than these are only counted.
const IDS_NAMED: usize = 12;

/// True of a file whose first line is a frame.
pub fn is_it(bytes: &[u8]) -> bool {
    first_lines(bytes)
        .next()
        .is_some_and(|line| frame(line).is_some())
}

/// One frame.
struct Frame {
    t_s: f64,
    bus: String,
    id: u32,
    data: Vec<u8>,
    line: u64,
}

/// Signals of the frames, by the DBC file beside the log.
///
/// # Errors
/// No DBC file, or a wrong one; a line that is no frame; signals that come over two buses.
pub fn read(file: &Path, bytes: &[u8], beside: &Beside) -> Result<Log, Error> {
    let text = decode(bytes);
    let (frames, cut_short) = frames(file, &text)?;
    let Some((dbc, layout)) = &beside.dbc else {
        let found = format!(
            "frames of CAN identifiers {}, and nothing that says which bits are which signal",
            counted(&frames)
        );
        let wanted = "--dbc FILE, where a line BO_ names a frame and lines SG_ its signals (docs/other-logs.md)";
        return Err(Error::new(file, found, wanted));
    };
    let messages = dbc::parse(dbc, layout)?;
    let (mut streams, mut notes) = (Vec::new(), Vec::new());
    for message in &messages {
        let of_it: Vec<&Frame> = frames
            .iter()
            .filter(|frame| frame.id == message.id)
            .collect();
        let Some(first) = of_it.first() else { continue };
        if let Some(other) = of_it.iter().find(|frame| frame.bus != first.bus) {
            let found = format!("{} on {} and on {}", message.name, first.bus, other.bus);
            return Err(Error::new(
                file,
                found,
                format!("one bus: grep ' {} ' {}", first.bus, file.display()),
            )
            .row(other.line));
        }
        let short = of_it
            .iter()
            .filter(|frame| !message.fits(&frame.data))
            .count();
        if short > 0 {
            notes.push(format!(
                "{short} frames {} are shorter than {} says",
                message.name,
                dbc.display()
            ));
        }
        streams.push(stream(message, &of_it));
    }
    let unknown: Vec<Frame> = frames
        .into_iter()
        .filter(|frame| messages.iter().all(|message| message.id != frame.id))
        .collect();
    if streams.is_empty() {
        let names: Vec<&str> = messages
            .iter()
            .map(|message| message.name.as_str())
            .take(IDS_NAMED)
            .collect();
        let found = format!("frames of CAN identifiers {}", counted(&unknown));
        return Err(Error::new(
            file,
            found,
            format!(
                "frames that {} describes: {}",
                dbc.display(),
                names.join(", ")
            ),
        ));
    }
    if !unknown.is_empty() {
        notes.push(format!(
            "{} does not describe identifiers {}: left aside",
            dbc.display(),
            counted(&unknown)
        ));
    }
    let mut log = together(file, "a log of candump", streams, beside)?;
    log.notes.extend(notes);
    log.cut_short = cut_short;
    Ok(log)
}

fn stream(message: &Message, frames: &[&Frame]) -> Stream {
    let mut columns: Vec<LogColumn> = message
        .signals
        .iter()
        .map(|signal| LogColumn {
            name: signal.name.clone(),
            unit: Some(signal.unit.clone()).filter(|unit| !unit.is_empty()),
            ..LogColumn::default()
        })
        .collect();
    for frame in frames {
        for (column, value) in columns.iter_mut().zip(message.values(&frame.data)) {
            column.numbers.push(value);
        }
    }
    Stream {
        name: message.name.clone(),
        t_s: frames.iter().map(|frame| frame.t_s).collect(),
        lines: frames.iter().map(|frame| frame.line).collect(),
        columns,
    }
}

/// All frames with data, and whether the last line was cut short.
fn frames(file: &Path, text: &str) -> Result<(Vec<Frame>, bool), Error> {
    let mut frames = Vec::new();
    let ended = text.ends_with('\n');
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .peekable();
    while let Some((place, line)) = lines.next() {
        let is_last = lines.peek().is_none();
        match frame(line) {
            // The end of a line that is cut off may be missing without a trace.
            Some(_) if is_last && !ended => return Ok((frames, true)),
            Some(Some(mut one)) => {
                one.line = place as u64 + 1;
                frames.push(one);
            }
            Some(None) => {}
            None if is_last => return Ok((frames, true)),
            None => {
                let wanted = "a frame with its time, as in (1764248400.000200) can0 123#0011: candump -L or -ta writes it";
                return Err(
                    Error::new(file, excerpt(line.as_bytes()), wanted).row(place as u64 + 1)
                );
            }
        }
    }
    Ok((frames, false))
}

/// The frame of a line; the inner one is none of an error of the bus and of a request for data.
fn frame(line: &str) -> Option<Option<Frame>> {
    let (time, rest) = line.trim().strip_prefix('(')?.split_once(')')?;
    let t_s = time.parse().ok().filter(|t_s: &f64| t_s.is_finite())?;
    let mut words = rest.split_whitespace();
    let bus = words.next()?.to_owned();
    let word = words.next()?;
    let (id, data) = match word.split_once('#') {
        Some((id, data)) => {
            // The first digit of CAN FD's are flags.
            let data = data
                .strip_prefix('#')
                .map_or(data, |data| data.get(1..).unwrap_or_default());
            if data.starts_with('R') {
                return Some(None);
            }
            (id, data.replace('.', ""))
        }
        None => {
            // `[8]`, or `[08]` of CAN FD.
            let length: usize = words
                .next()?
                .strip_prefix('[')?
                .strip_suffix(']')?
                .parse()
                .ok()?;
            (word, words.take(length).collect())
        }
    };
    let wide = id.len() > 3;
    let id = u32::from_str_radix(id, 16).ok()?;
    // Bits 29 and 30 are not of identifiers: they mark errors.
    if id >> 29 != 0 || data == "remoterequest" {
        return Some(None);
    }
    let data = (0..data.len())
        .step_by(2)
        .map(|at| u8::from_str_radix(data.get(at..at + 2)?, 16).ok())
        .collect::<Option<Vec<u8>>>()?;
    let id = if wide { id | EXTENDED } else { id };
    Some(Some(Frame {
        t_s,
        bus,
        id,
        data,
        line: 0,
    }))
}

/// `009 (240), 18FEF1FE (60)`.
fn counted(frames: &[Frame]) -> String {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    frames
        .iter()
        .for_each(|frame| *counts.entry(frame.id).or_default() += 1);
    let told = |(id, count): (&u32, &usize)| match id & EXTENDED {
        0 => format!("{id:03X} ({count})"),
        _ => format!("{:08X} ({count})", id & !EXTENDED),
    };
    let mut text: Vec<String> = counts.iter().take(IDS_NAMED).map(told).collect();
    if counts.len() > IDS_NAMED {
        text.push(format!("{} more", counts.len() - IDS_NAMED));
    }
    text.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_each_kind() {
        for (line, id, data) in [
            ("(1.5) can0 123#0011", 0x123, &[0, 0x11][..]),
            ("(1.5) vcan1 00000123#00.11 T", 0x8000_0123, &[0, 0x11]),
            ("(1.5) can0 123##300112233", 0x123, &[0, 0x11, 0x22, 0x33]),
            ("(1.5) can0 123#", 0x123, &[]),
            (
                " (1.5)  can0  18FEF1FE   [2]  00 11   '..'",
                0x98fe_f1fe,
                &[0, 0x11],
            ),
            ("(1.5)  can0  123  [02]  00 11", 0x123, &[0, 0x11]),
        ] {
            let frame = frame(line).flatten().unwrap_or_else(|| panic!("{line}"));
            assert_eq!(
                (frame.id, frame.data.as_slice(), frame.t_s),
                (id, data, 1.5),
                "{line}"
            );
        }
        for line in [
            "(1.5) can0 123#R",
            "(1.5) can0 123#R8",
            "(1.5) can0 20000004#0004000000000000",
            "(1.5)  can0  123   [0]  remote request",
        ] {
            assert!(
                frame(line).is_some_and(|frame| frame.is_none_or(|frame| frame.data.is_empty())),
                "{line}"
            );
        }
        for line in [
            "",
            "can0 123#0011",
            "(x) can0 123#0011",
            "(1.5) can0",
            "(1.5) can0 123#001",
            "(1.5) can0 xyz#00",
            "(1.5) can0 123 00",
        ] {
            assert!(frame(line).is_none(), "{line}");
        }
    }
}
