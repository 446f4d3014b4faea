//! Frames of a CAN bus as candump of can-utils and python-can write them, by the DBC file beside them.

use super::beside::Beside;
use super::dbc::{self, Message, Said};
use super::frames::{self, EXTENDED, Frame, Frames};
use super::streams::{Stream, together};
use crate::table::{Log, LogColumn, told_how};
use crate::text::decode;
use recording::Error;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// How a sensor's signal comes into a log.
pub const HOW_TO_RECORD: &str = "candump -L CHANNEL while the device sends the frame of its position, and a line SG_ for it in the DBC file";
/// More kinds of frames than these are only counted.
const IDS_NAMED: usize = 12;

/// Signals of the frames, by the DBC file beside the log.
///
/// # Errors
/// No DBC file, or a wrong one; a line that is no frame; signals that come over two buses.
pub fn read(file: &Path, bytes: &[u8], beside: &Beside) -> Result<Log, Error> {
    let text = decode(bytes);
    let Frames {
        frames,
        cut_short,
        mut notes,
    } = frames::parse(file, &text)?;
    let Some((dbc, layout)) = &beside.dbc else {
        let found = format!(
            "frames of CAN identifiers {}, and nothing that says which bits are which signal",
            counted(&frames)
        );
        let wanted = "--dbc FILE, where a line BO_ names a frame and lines SG_ its signals (docs/other-logs.md)";
        return Err(Error::new(file, found, wanted));
    };
    let messages = dbc::parse(dbc, layout)?;
    let mut streams = Vec::new();
    for message in &messages {
        let of_it: Vec<&Frame> = frames
            .iter()
            .filter(|frame| message.is_of(frame.id))
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
        streams.extend(by_sender(message, &of_it));
    }
    let unknown: Vec<Frame> = frames
        .into_iter()
        .filter(|frame| !messages.iter().any(|message| message.is_of(frame.id)))
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
                "frames that {} describes: {}{}",
                dbc.display(),
                names.join(", "),
                told_how(HOW_TO_RECORD)
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
    log.notes.append(&mut notes);
    log.cut_short = cut_short;
    Ok(log)
}

/// A stream of each sender where the DBC file names none and there are several: `MESSAGE_23`, by its address.
fn by_sender(message: &Message, frames: &[&Frame]) -> Vec<Stream> {
    let ids: BTreeSet<u32> = frames.iter().map(|frame| frame.id).collect();
    let senders: BTreeSet<u8> = ids.iter().map(|id| id.to_le_bytes()[0]).collect();
    if ids.len() < 2 || senders.len() < 2 {
        return vec![stream(message, message.name.clone(), frames)];
    }
    let one = |sender: &u8| {
        let own: Vec<&Frame> = frames
            .iter()
            .copied()
            .filter(|frame| frame.id.to_le_bytes()[0] == *sender)
            .collect();
        stream(message, format!("{}_{sender:02X}", message.name), &own)
    };
    senders.iter().map(one).collect()
}

fn stream(message: &Message, name: String, frames: &[&Frame]) -> Stream {
    let mut columns: Vec<LogColumn> = message
        .signals
        .iter()
        .map(|signal| LogColumn {
            name: signal.name.clone(),
            unit: Some(signal.unit.clone()).filter(|unit| !unit.is_empty()),
            ..LogColumn::default()
        })
        .collect();
    let mut none_s = vec![Vec::new(); columns.len()];
    for frame in frames {
        for (place, said) in message.said(&frame.data).into_iter().enumerate() {
            let value = match said {
                Said::Value(value) => value,
                Said::Absent => f64::NAN,
                Said::None => {
                    none_s[place].push(frame.t_s);
                    f64::NAN
                }
            };
            columns[place].numbers.push(value);
        }
    }
    Stream {
        name,
        t_s: frames.iter().map(|frame| frame.t_s).collect(),
        lines: frames.iter().map(|frame| frame.line).collect(),
        columns,
        none_s,
    }
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
