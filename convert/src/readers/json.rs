//! Lines of JSON, an object each: what tview of moteus writes (`controller`, `timestamp`, `channel`, `data`), what `courier monitor --json`
//! prints, and objects of any other program's.

use super::beside::{Beside, first_lines};
use super::streams::{Stream, together};
use crate::table::{Log, LogColumn};
use recording::{Error, excerpt};
use serde_json::Value;
use std::path::Path;

/// True of a file whose first line is a whole object.
pub fn is_it(bytes: &[u8]) -> bool {
    first_lines(bytes)
        .next()
        .is_some_and(|line| line.starts_with('{') && line.ends_with('}') && line.len() > 2)
}

/// The numbers of the objects; of an object in an object `outer.inner`, of a list `name[0]`.
///
/// # Errors
/// A line that is no object.
pub fn read(file: &Path, bytes: &[u8], beside: &Beside) -> Result<Log, Error> {
    let text = String::from_utf8_lossy(bytes);
    let mut streams: Vec<Stream> = Vec::new();
    let mut cut_short = false;
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .peekable();
    while let Some((place, line)) = lines.next() {
        let Some(object) = object(line) else {
            if lines.peek().is_none() {
                cut_short = true;
                break;
            }
            return Err(Error::new(
                file,
                excerpt(line.as_bytes()),
                "an object of JSON in each line",
            )
            .row(place as u64 + 1));
        };
        let (name, time, data) = parts(&object);
        let at = streams
            .iter()
            .position(|stream| stream.name == name)
            .unwrap_or_else(|| {
                streams.push(Stream {
                    name,
                    ..Stream::default()
                });
                streams.len() - 1
            });
        let stream = &mut streams[at];
        stream.t_s.push(time.unwrap_or(f64::NAN));
        stream.lines.push(place as u64 + 1);
        flatten(data, "", stream);
        let rows = stream.t_s.len();
        stream
            .columns
            .iter_mut()
            .for_each(|column| column.numbers.resize(rows, f64::NAN));
    }
    let mut log = match streams.as_mut_slice() {
        // One kind: its columns are as they are, time among them.
        [one] if one.t_s.iter().any(|t_s| t_s.is_nan()) => {
            let one = std::mem::take(one);
            let mut log = Log::of_columns(one.columns);
            (log.form, log.lines) = ("lines of JSON", one.lines);
            log
        }
        _ => together(file, "lines of JSON", streams, beside)?,
    };
    log.cut_short = cut_short;
    Ok(log)
}

/// Python writes `NaN` and `Infinity`, which JSON has not.
fn object(line: &str) -> Option<Value> {
    let parsed = serde_json::from_str::<Value>(line).or_else(|_| {
        let plain = ["-Infinity", "Infinity", "NaN"]
            .iter()
            .fold(line.to_owned(), |text, word| {
                text.replace(&format!(": {word}"), ": null")
            });
        serde_json::from_str(&plain)
    });
    parsed.ok().filter(Value::is_object)
}

/// Kind of message, time in seconds and values; the object itself where it is no message of tview's.
fn parts(object: &Value) -> (String, Option<f64>, &Value) {
    match (&object["channel"], &object["timestamp"], &object["data"]) {
        (Value::String(channel), Value::Number(time), data @ Value::Object(_)) => {
            let controller = object["controller"].as_str().unwrap_or_default();
            let name = if controller.is_empty() {
                channel.clone()
            } else {
                format!("{controller}.{channel}")
            };
            (name, time.as_f64(), data)
        }
        _ => (String::new(), None, object),
    }
}

fn flatten(value: &Value, name: &str, stream: &mut Stream) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let name = if name.is_empty() {
                    key.clone()
                } else {
                    format!("{name}.{key}")
                };
                flatten(value, &name, stream);
            }
        }
        Value::Array(list) => list
            .iter()
            .enumerate()
            .for_each(|(place, value)| flatten(value, &format!("{name}[{place}]"), stream)),
        _ => {
            let row = stream.t_s.len() - 1;
            let column = match stream.columns.iter_mut().find(|column| column.name == name) {
                Some(column) => column,
                None => {
                    stream.columns.push(LogColumn {
                        name: name.to_owned(),
                        ..LogColumn::default()
                    });
                    let last = stream.columns.len() - 1;
                    &mut stream.columns[last]
                }
            };
            column.numbers.resize(row, f64::NAN);
            column.numbers.push(match value {
                Value::Bool(truth) => f64::from(u8::from(*truth)),
                _ => value.as_f64().unwrap_or(f64::NAN),
            });
            if let Value::String(word) = value {
                column.words.push((row, word.clone()));
            }
        }
    }
}
