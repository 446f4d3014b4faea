//! What a file is, told by its content: an output replaces only a file of its own kind.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Most of a file that is read to tell its kind, bytes. A diagnosed model of a field is some 10 MB.
const LIMIT_BYTES: u64 = 1 << 28;

/// What a command writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// JSON.
    Json {
        /// What it is called.
        what: &'static str,
        /// Keys that its object has, or the first object of its list.
        keys: &'static [&'static str],
    },
    /// JSON, an object a line.
    Lines {
        /// What it is called.
        what: &'static str,
        /// Keys that the first line's object has.
        keys: &'static [&'static str],
    },
    /// A page that has this text in its head, which says who made it.
    Page {
        /// The text.
        made_by: &'static str,
    },
}

impl Kind {
    /// JSON with these keys.
    pub const fn json(what: &'static str, keys: &'static [&'static str]) -> Self {
        Self::Json { what, keys }
    }

    /// What it is called.
    pub fn what(self) -> &'static str {
        match self {
            Self::Json { what, .. } | Self::Lines { what, .. } => what,
            Self::Page { .. } => "a page that courier made",
        }
    }

    /// Refuses a path where there is a file of another kind. An empty file and what is no file, a pipe or a device, are written to.
    ///
    /// # Errors
    /// There is one, or what is there cannot be read.
    pub fn check(self, path: &Path) -> Result<()> {
        let there = match std::fs::metadata(path) {
            Ok(there) if there.is_file() && there.len() > 0 => there,
            _ => return Ok(()),
        };
        let mut bytes = Vec::new();
        File::open(path)
            .and_then(|file| file.take(LIMIT_BYTES).read_to_end(&mut bytes))
            .with_context(|| {
                format!(
                    "{}: found a file that cannot be read, wanted {} or a new file",
                    path.display(),
                    self.what()
                )
            })?;
        if (there.len() <= LIMIT_BYTES) && self.is_that_of(&bytes) {
            return Ok(());
        }
        bail!(
            "{}: found a file of another kind, wanted {} to replace, or a new file",
            path.display(),
            self.what()
        );
    }

    /// Whether these are the bytes of a file of this kind.
    fn is_that_of(self, bytes: &[u8]) -> bool {
        match self {
            Self::Json { keys, .. } => {
                serde_json::from_slice(bytes).is_ok_and(|value| has(&value, keys))
            }
            Self::Lines { keys, .. } => bytes
                .split(|byte| *byte == b'\n')
                .next()
                .and_then(|line| serde_json::from_slice(line).ok())
                .is_some_and(|value| has(&value, keys)),
            Self::Page { made_by } => {
                std::str::from_utf8(bytes).is_ok_and(|text| text.contains(made_by))
            }
        }
    }
}

/// Whether an object, or the first of a list, has these keys.
fn has(value: &Value, keys: &[&str]) -> bool {
    match value {
        Value::Object(object) => keys.iter().all(|key| object.contains_key(*key)),
        Value::Array(list) => list
            .first()
            .is_some_and(|first| first.is_object() && has(first, keys)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_of_the_kind_whose_keys_it_has() {
        let is = |kind: Kind, text: &str| kind.is_that_of(text.as_bytes());
        let calibration = Kind::json("a calibration", &["calibration"]);
        assert!(is(calibration, r#"{"calibration": 3}"#));
        assert!(!is(calibration, r#"{"map": 3}"#));
        let slots = Kind::json("slots", &["slot"]);
        assert!(is(slots, r#"[{"slot": 0}]"#));
        for text in ["[]", "{}", "7", "", "t_s,q1s\n0,1\n", "[[{}]]"] {
            assert!(!is(slots, text), "{text}");
        }
        let lines = Kind::Lines {
            what: "samples",
            keys: &["t_s"],
        };
        assert!(is(lines, "{\"t_s\": 0}\n{\"t_s\": 1}\n"));
        assert!(!is(lines, "{\n  \"t_s\": 0\n}\n"));
        let page = Kind::Page {
            made_by: "<meta courier>",
        };
        assert!(!is(page, "<!DOCTYPE html><title>mine</title>"));
        assert!(is(page, "<!DOCTYPE html><meta courier>"));
    }
}
