//! Logs of other programs, told apart by what their bytes say.
//!
//! Each reader is a file here and a line of [`READERS`]. What none of them knows is a table of text. `streams` brings together what came
//! in messages of several kinds, `known` knows the units of columns by their programs' names.

mod archive;
mod beside;
mod candump;
mod dbc;
mod frames;
mod json;
mod known;
mod literal;
mod moteus;
mod numpy;
mod refused;
mod reserved;
mod simplefoc;
mod streams;

pub use beside::Beside;
pub use streams::{Stream, together};

use crate::table::Log;
use crate::text::decode;
use recording::Error;
use std::path::Path;

/// One program's logs.
struct Reader {
    is_it: fn(&[u8]) -> bool,
    read: fn(&Path, &[u8], &Beside) -> Result<Log, Error>,
    /// How the output of a sensor is recorded with it; none where many programs write such files.
    how_to_record: Option<&'static str>,
}

/// All of them; the first that takes a file reads it.
const READERS: [Reader; 7] = [
    Reader {
        is_it: numpy::is_it,
        read: |file, bytes, _| numpy::read(file, bytes),
        how_to_record: Some(numpy::HOW_TO_RECORD),
    },
    Reader {
        is_it: archive::is_it,
        read: |file, bytes, _| archive::read(file, bytes),
        how_to_record: Some(numpy::HOW_TO_RECORD),
    },
    Reader {
        is_it: frames::is_it,
        read: candump::read,
        how_to_record: Some(candump::HOW_TO_RECORD),
    },
    Reader {
        is_it: moteus::is_it,
        read: |file, bytes, _| moteus::read(file, bytes),
        how_to_record: Some(moteus::HOW_TO_RECORD),
    },
    Reader {
        is_it: json::is_it,
        read: json::read,
        how_to_record: None,
    },
    Reader {
        is_it: simplefoc::is_it,
        read: |file, bytes, _| simplefoc::read(file, bytes),
        how_to_record: Some(simplefoc::HOW_TO_RECORD),
    },
    Reader {
        is_it: refused::is_it,
        read: |file, bytes, _| refused::read(file, bytes),
        how_to_record: None,
    },
];

/// The log in a file's bytes.
///
/// # Errors
/// No program that is known wrote it whole, or what it needs beside it is missing.
pub fn read(file: &Path, bytes: &[u8], beside: &Beside) -> Result<Log, Error> {
    let refuse = |option: &str, wanted: &str| {
        Err(Error::new(
            file,
            format!("a log that {option} says nothing of"),
            wanted,
        ))
    };
    let is_bus = frames::is_it(bytes);
    if beside.dbc.is_some() && !is_bus {
        return refuse("--dbc", "--dbc beside frames of candump alone");
    }
    if beside.rows_of.is_some() && !is_bus && !json::is_it(bytes) {
        return refuse(
            "--rows-of",
            "--rows-of beside a log with several kinds of messages alone",
        );
    }
    let log = match READERS.iter().find(|reader| (reader.is_it)(bytes)) {
        Some(reader) => Log {
            how_to_record: reader.how_to_record,
            ..(reader.read)(file, bytes, beside)?
        },
        None => Log::read(file, &decode(bytes))?,
    };
    known::named(log).with_rows(file)
}
