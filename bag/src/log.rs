//! A bag of another program's, or what a monitor saw, as a log, of which `convert` makes a recording.

use crate::definition::Definition;
use crate::flatten::{Flattened, flatten};
use crate::open::{open, walk};
use convert::{Beside, Log, LogColumn, Stream, together};
use recording::Error;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Stamps in headers are the times of a topic where they are this near to the log's own, s: else they are of another clock, or were not set.
const NEAR_S: f64 = 60.0;

/// The topics of a file, each a kind of messages: those of ROS 2 (`ros2msg` and CDR) and of JSON. A topic's times are the stamps of its
/// headers, or when a message was logged.
///
/// # Errors
/// It is no MCAP file, or holds no messages that are known.
pub fn log(path: &Path, beside: &Beside) -> Result<Log, Error> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut places: HashMap<u16, usize> = HashMap::new();
    let mut first_ns = None;
    let whole = walk(
        path,
        open(path)?,
        |_, _| Ok(()),
        |message| {
            let first_ns = *first_ns.get_or_insert(message.time_ns);
            let place = *places.entry(message.channel.id).or_insert_with(|| {
                topics.push(Topic::new(&message.channel));
                topics.len() - 1
            });
            topics[place].push(message.time_ns, first_ns, message.data);
            Ok(())
        },
    )?;
    let mut notes: Vec<String> = topics.iter().filter_map(Topic::left_aside).collect();
    let known = topics.iter().filter(|topic| topic.rows() > 0).count();
    if known == 0 {
        let found = if notes.is_empty() {
            "no messages".to_owned()
        } else {
            notes.join("; ")
        };
        return Err(Error::new(
            path,
            found,
            "messages of ROS 2 (ros2msg, CDR) or JSON",
        ));
    }
    let stamped = topics
        .iter()
        .filter(|topic| topic.rows() > 0)
        .all(Topic::stamps_are_near_or_none);
    notes.extend(topics.iter().flat_map(|topic| topic.told(stamped)));
    let streams = topics
        .into_iter()
        .map(|topic| topic.stream(stamped))
        .collect();
    let mut log = together(path, "an MCAP file", streams, beside)?;
    log.notes.extend(notes);
    if !whole {
        log.notes.push("the end of the file is missing: it was cut, or is still written; what is there was read".into());
    }
    Ok(log)
}

enum Form {
    Ros(Definition),
    Json,
    /// Why its messages are not read.
    Unknown(String),
}

/// The messages of one topic.
struct Topic {
    name: String,
    form: Form,
    logged_s: Vec<f64>,
    stamped_s: Vec<f64>,
    columns: Vec<LogColumn>,
    /// Rows whose message gives a column a number that is none, of each column.
    nones: Vec<Vec<usize>>,
    by_name: HashMap<String, usize>,
    long: Vec<String>,
    spoilt: usize,
}

impl Topic {
    fn new(channel: &mcap::Channel) -> Self {
        let schema = channel.schema.as_deref();
        let form = match (channel.message_encoding.as_str(), schema) {
            ("json", _) => Form::Json,
            ("cdr", Some(schema)) if schema.encoding == "ros2msg" => {
                match Definition::parse(&schema.name, &String::from_utf8_lossy(&schema.data)) {
                    Ok(definition) => Form::Ros(definition),
                    Err(found) => Form::Unknown(found),
                }
            }
            (encoding, schema) => Form::Unknown(format!(
                "messages of {encoding} with definitions of {}",
                schema.map_or("none", |schema| &schema.encoding)
            )),
        };
        Self {
            name: channel.topic.clone(),
            form,
            logged_s: Vec::new(),
            stamped_s: Vec::new(),
            columns: Vec::new(),
            nones: Vec::new(),
            by_name: HashMap::new(),
            long: Vec::new(),
            spoilt: 0,
        }
    }

    fn rows(&self) -> usize {
        self.logged_s.len()
    }

    fn push(&mut self, time_ns: u64, first_ns: u64, data: &[u8]) {
        let values = match &self.form {
            Form::Ros(definition) => flatten(definition, data),
            Form::Json => serde_json::from_slice::<Value>(data).ok().map(|value| {
                let mut into = Flattened::default();
                of_json(&value, "", &mut into);
                into
            }),
            Form::Unknown(_) => None,
        };
        let Some(values) = values else {
            self.spoilt += 1;
            return;
        };
        let row = self.rows();
        // Differences of whole nanoseconds: seconds of today have no microseconds left in them.
        self.logged_s
            .push((i128::from(time_ns) - i128::from(first_ns)) as f64 * 1e-9);
        self.stamped_s
            .push(values.stamp_ns.map_or(f64::NAN, |stamp| {
                (i128::from(stamp) - i128::from(first_ns)) as f64 * 1e-9
            }));
        for (name, number) in values.numbers {
            let place = self.place(name, row);
            self.columns[place].numbers.push(number);
            if !number.is_finite() {
                self.nones[place].push(row);
            }
        }
        for (name, word) in values.words {
            let place = self.place(name, row);
            let column = &mut self.columns[place];
            column.numbers.push(f64::NAN);
            column.words.push((row, word));
        }
        self.columns
            .iter_mut()
            .for_each(|column| column.numbers.resize(row + 1, f64::NAN));
        for name in values.long {
            if !self.long.contains(&name) {
                self.long.push(name);
            }
        }
    }

    /// Number of the column of this name, which is filled up to a row.
    fn place(&mut self, name: String, row: usize) -> usize {
        let (columns, nones) = (&mut self.columns, &mut self.nones);
        let place = *self.by_name.entry(name).or_insert_with_key(|name| {
            columns.push(LogColumn {
                name: name.clone(),
                ..LogColumn::default()
            });
            nones.push(Vec::new());
            columns.len() - 1
        });
        // A second value of one name in one message takes the place of the first.
        columns[place].numbers.resize(row, f64::NAN);
        nones[place].pop_if(|of| *of == row);
        place
    }

    fn left_aside(&self) -> Option<String> {
        match &self.form {
            Form::Unknown(why) => Some(format!("{} was left aside: {why}", self.name)),
            _ if self.rows() == 0 => Some(format!(
                "{} was left aside: its messages do not fit their definition",
                self.name
            )),
            _ => None,
        }
    }

    fn stamps_are_near_or_none(&self) -> bool {
        let pairs = self.stamped_s.iter().zip(&self.logged_s);
        pairs
            .into_iter()
            .all(|(stamp, logged)| stamp.is_nan() || (stamp - logged).abs() < NEAR_S)
    }

    fn told(&self, stamped: bool) -> Vec<String> {
        let mut told = Vec::new();
        if self.rows() > 0 && self.spoilt > 0 {
            told.push(format!(
                "{} messages of {} do not fit their definition and were left out",
                self.spoilt, self.name
            ));
        }
        if !self.long.is_empty() {
            told.push(format!(
                "{}: {} left aside, lists of many values",
                self.name,
                self.long.join(", ")
            ));
        }
        match self.stamped_s.iter().any(|stamp| stamp.is_finite()) {
            true if stamped => told.push(format!("times of {} are its header's stamps", self.name)),
            true => told.push(format!("times of {} are when it was logged: not all stamps in headers are of the log's clock", self.name)),
            false => {}
        }
        told
    }

    fn stream(self, stamped: bool) -> Stream {
        let has_stamps = stamped && self.stamped_s.iter().all(|stamp| stamp.is_finite());
        let lines = (1..=self.rows() as u64).collect();
        let t_s = if has_stamps {
            self.stamped_s
        } else {
            self.logged_s
        };
        let times = |rows: &Vec<usize>| rows.iter().map(|row| t_s[*row]).collect();
        Stream {
            none_s: self.nones.iter().map(times).collect(),
            lines,
            name: self.name,
            t_s,
            columns: self.columns,
        }
    }
}

fn of_json(value: &Value, name: &str, into: &mut Flattened) {
    match value {
        Value::Object(object) => {
            let sorted: BTreeMap<&String, &Value> = object.iter().collect();
            for (key, value) in sorted {
                let name = if name.is_empty() {
                    key.clone()
                } else {
                    format!("{name}.{key}")
                };
                of_json(value, &name, into);
            }
        }
        Value::Array(list) => list
            .iter()
            .enumerate()
            .for_each(|(place, value)| of_json(value, &format!("{name}[{place}]"), into)),
        Value::Bool(truth) => into
            .numbers
            .push((name.to_owned(), f64::from(u8::from(*truth)))),
        Value::String(word) => into.words.push((name.to_owned(), word.clone())),
        _ => into
            .numbers
            .push((name.to_owned(), value.as_f64().unwrap_or(f64::NAN))),
    }
}
