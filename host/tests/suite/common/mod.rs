//! Runs the built command; finds the real recordings.
#![allow(dead_code)] // each test program uses its own part

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a run of `courier` gave.
pub struct Ran {
    asked: String,
    /// Exit code; -1 if it was killed.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Ran {
    /// What it printed: it must have ended well, and warned of nothing.
    pub fn quiet(self) -> String {
        assert_eq!(
            (self.code, self.err.as_str()),
            (0, ""),
            "{}: {}",
            self.asked,
            self.out
        );
        self.out
    }

    /// What it printed, as JSON.
    pub fn json(self) -> Value {
        json(&self.quiet())
    }

    /// It must have refused in one line that holds these words, printed nothing else, and ended with exit code 2.
    pub fn refused(&self, wanted: &[&str]) {
        let Self { asked, err, .. } = self;
        assert_eq!((self.code, self.out.as_str()), (2, ""), "{asked}: {err}");
        assert_eq!(err.trim_end().lines().count(), 1, "{asked}: {err}");
        for word in wanted {
            assert!(err.contains(word), "{asked}: wanted {word:?} in {err}");
        }
    }

    /// The command line must have been refused for these words: exit code 2, nothing on standard output.
    pub fn refused_usage(&self, wanted: &str) {
        let Self { asked, err, .. } = self;
        assert_eq!((self.code, self.out.as_str()), (2, ""), "{asked}: {err}");
        assert!(err.contains(wanted), "{asked}: wanted {wanted:?} in {err}");
    }
}

/// JSON, or a failed test that shows the text.
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// The JSON in a file.
pub fn json_in(path: impl AsRef<Path>) -> Value {
    json(&std::fs::read_to_string(path).unwrap())
}

/// A figure of this system in the table that `demo --json` or `isolability --json` gives: the entry of `list` with this `key`.
pub fn entry<'a>(report: &'a Value, list: &str, key: &str, name: &str) -> &'a Value {
    let rows = report[list].as_array().unwrap();
    let found = rows.iter().find(|row| row[key] == name);
    found.unwrap_or_else(|| panic!("no {name} in {report}"))
}

/// Runs the built `courier` with these arguments in `folder`.
pub fn courier_in(folder: &Path, arguments: &[&str]) -> Ran {
    let Output {
        status,
        stdout,
        stderr,
    } = Command::new(env!("CARGO_BIN_EXE_courier"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran {
        asked: arguments.join(" "),
        code: status.code().unwrap_or(-1),
        out: text(stdout),
        err: text(stderr),
    }
}

/// Runs the built `courier` with these words in `folder`.
pub fn asked(folder: &Path, words: &str) -> Ran {
    courier_in(folder, &words.split_whitespace().collect::<Vec<_>>())
}

/// A short platen calibration of the `ideal` courier, stored in `a.bin`.
pub const CALIBRATE: &str =
    "--sim-preset ideal --sim-flash a.bin calibrate --plan optimal --poses 100 --held-out 40";

/// Runs the built `courier` with these arguments.
pub fn courier(arguments: &[&str]) -> Ran {
    courier_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// A folder of real data, in `$COURIER_SHARED/data` or `../shared/data`; none, and said so, where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    shared_folder(Path::new("data").join(name))
}

/// A folder in `$COURIER_SHARED` or `../shared`; none, and said so, where it is absent.
pub fn shared_folder(name: impl AsRef<Path>) -> Option<PathBuf> {
    let shared = std::env::var_os("COURIER_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let path = shared.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!(
        "SKIPPED: nothing at {}; set COURIER_SHARED to the folder that holds data/ and cases/",
        path.display()
    );
    None
}
