//! The keys of one table of `recording.toml`, checked as they are taken.

use crate::META_FILE;
use crate::error::{Error, excerpt, one_line};
use std::path::Path;
use toml::{Table, Value};

/// Range of numbers that a key may have.
pub(crate) type Range = (f64, f64);

pub(crate) fn missing(file: &Path, key: &str, wanted: &str) -> Error {
    Error::new(file, "none", wanted).column(key)
}

pub(crate) fn describe(value: &Value) -> String {
    match value {
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        Value::String(text) => excerpt(text.as_bytes()),
        other => format!("a value of type {}", other.type_str()),
    }
}

/// One table's keys, with those that are known.
pub(crate) struct Keys<'a> {
    file: &'a Path,
    name: &'a str,
    table: &'a Table,
    unknown: Vec<String>,
}

impl<'a> Keys<'a> {
    pub(crate) fn new(file: &'a Path, name: &'a str, table: &'a Table, known: &[&str]) -> Self {
        let unknown = table
            .keys()
            .filter(|key| !known.contains(&key.as_str()))
            .map(|key| path_of(name, key))
            .collect();
        Self {
            file,
            name,
            table,
            unknown,
        }
    }

    pub(crate) fn error(&self, key: &str, found: String, wanted: &str) -> Error {
        Error::new(self.file, found, wanted).column(path_of(self.name, key))
    }

    pub(crate) fn text(&self, key: &str) -> Result<String, Error> {
        match self.table.get(key) {
            None => Ok(String::new()),
            Some(Value::String(text)) => Ok(text.clone()),
            Some(other) => Err(self.error(key, describe(other), "text in quotes")),
        }
    }

    /// A sub-table, whose unknown keys are remembered here.
    pub(crate) fn table(
        &mut self,
        key: &'a str,
        known: &[&str],
    ) -> Result<Option<Keys<'a>>, Error> {
        match self.table.get(key) {
            None => Ok(None),
            Some(Value::Table(table)) => {
                let mut keys = Keys::new(self.file, key, table, known);
                self.unknown.append(&mut keys.unknown);
                Ok(Some(keys))
            }
            Some(other) => Err(self.error(key, describe(other), "a table")),
        }
    }

    pub(crate) fn number(&self, key: &str, (low, high): Range) -> Result<Option<f64>, Error> {
        let number = match self.table.get(key) {
            None => return Ok(None),
            Some(Value::Integer(number)) => *number as f64,
            Some(Value::Float(number)) => *number,
            Some(other) => return Err(self.error(key, describe(other), "a number")),
        };
        if !(low..=high).contains(&number) {
            return Err(self.error(
                key,
                number.to_string(),
                &format!("{low:?} to {high:?}{}", unit_of(key)),
            ));
        }
        Ok(Some(number))
    }

    pub(crate) fn required(&self, key: &str, range: Range) -> Result<f64, Error> {
        self.number(key, range)?
            .ok_or_else(|| missing(self.file, &path_of(self.name, key), "a number"))
    }

    pub(crate) fn warn(self, warnings: &mut Vec<String>) {
        for key in self.unknown {
            warnings.push(format!(
                "{META_FILE}: key {} is not known and is left aside",
                one_line(&key, 60)
            ));
        }
    }
}

fn unit_of(key: &str) -> &'static str {
    if key.ends_with("_m") { " m" } else { "" }
}

fn path_of(table: &str, key: &str) -> String {
    if table.is_empty() {
        key.to_owned()
    } else {
        format!("[{table}] {key}")
    }
}
