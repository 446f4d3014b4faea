//! The messages of one topic, column by column.

use crate::definition::Definition;
use crate::flatten::{Flattened, flatten};
use convert::{LogColumn, Stream};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};

/// Stamps in headers are the times of a topic where they are this near to the log's own, s: else they are of another clock, or were not set.
const NEAR_S: f64 = 60.0;

/// How the messages of a topic are packed.
#[derive(Clone, Debug)]
pub enum Form {
    /// ROS 2's, by their definition.
    Ros(Definition),
    /// JSON's.
    Json,
    /// Why its messages are not read.
    Unknown(String),
}

/// The messages of one topic.
#[derive(Clone, Debug)]
pub struct Topic {
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
    /// A topic of this name without messages.
    #[must_use]
    pub fn new(name: String, form: Form) -> Self {
        Self {
            name,
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

    /// Number of messages that were read.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.logged_s.len()
    }

    /// Takes a message that was logged at this time, ns; the first of all topics was at `first_ns`.
    pub fn push(&mut self, time_ns: u64, first_ns: u64, data: &[u8]) {
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

    /// Why nothing of it was read, if nothing was.
    #[must_use]
    pub fn left_aside(&self) -> Option<String> {
        match &self.form {
            Form::Unknown(why) => Some(format!("{} was left aside: {why}", self.name)),
            _ if self.rows() == 0 => Some(format!(
                "{} was left aside: its messages do not fit their definition",
                self.name
            )),
            _ if self.columns.is_empty() => {
                let why = match self.long.is_empty() {
                    true => "its messages hold no numbers".to_owned(),
                    false => format!("{}, lists of many values", self.long.join(", ")),
                };
                Some(format!("{} was left aside: {why}", self.name))
            }
            _ => None,
        }
    }

    /// Whether the stamps of its headers are of the log's own clock, or it has none.
    #[must_use]
    pub fn stamps_are_near_or_none(&self) -> bool {
        let pairs = self.stamped_s.iter().zip(&self.logged_s);
        pairs
            .into_iter()
            .all(|(stamp, logged)| stamp.is_nan() || (stamp - logged).abs() < NEAR_S)
    }

    /// What is said of it; `stamped` if stamps are the times of all topics.
    #[must_use]
    pub fn told(&self, stamped: bool) -> Vec<String> {
        let mut told = Vec::new();
        if self.rows() > 0 && self.spoilt > 0 {
            told.push(format!(
                "{} messages of {} do not fit their definition and were left out",
                self.spoilt, self.name
            ));
        }
        if !self.long.is_empty() && !self.columns.is_empty() {
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

    /// Its columns over time; `stamped` as for [`Self::told`].
    #[must_use]
    pub fn stream(self, stamped: bool) -> Stream {
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

#[cfg(test)]
mod tests {
    use super::*;
    use convert::{Beside, Log, together};
    use std::path::Path;

    /// The messages of one topic with a value each, and of another with a value at every third.
    fn log_of_json(values: [&str; 9]) -> Log {
        let [mut fast, mut slow] =
            ["/fast", "/slow"].map(|name| Topic::new(name.into(), Form::Json));
        for k in 0..27 {
            let time_ns = k * 1_000_000;
            fast.push(time_ns, 0, format!("{{\"x\": {k}}}").as_bytes());
            if k % 3 == 0 {
                let value = values[k as usize / 3];
                slow.push(time_ns, 0, format!("{{{value}}}").as_bytes());
            }
        }
        let streams = [fast, slow].map(|topic| topic.stream(true)).into();
        together(
            Path::new("values.mcap"),
            "an MCAP file",
            streams,
            &Beside::default(),
        )
        .unwrap()
    }

    /// A message that has no number for a value is not bridged by its neighbours; one that leaves the value out says nothing of it.
    #[test]
    fn nothing_is_interpolated_over_what_is_no_number() {
        let mut values = ["\"y\": 1.0"; 9];
        values[2] = "\"y\": null";
        values[5] = "\"z\": 0.0";
        let log = log_of_json(values);
        let column = log.columns.iter().find(|column| column.name == "/slow.y");
        let numbers = &column.unwrap().numbers;
        let missing: Vec<usize> = (0..25).filter(|row| numbers[*row].is_nan()).collect();
        assert_eq!(missing, [4, 5, 6, 7, 8]);
        let told = "1 of 9 messages /slow say that y has no value";
        assert!(log.notes.iter().any(|note| note == told), "{:?}", log.notes);
    }
}
