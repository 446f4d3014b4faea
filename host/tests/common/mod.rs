//! Runs the built command; finds the real recordings.
#![allow(dead_code)] // each test program uses its own part

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a run of `courier` gave.
pub struct Ran {
    /// Exit code; -1 if it was killed.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
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
        code: status.code().unwrap_or(-1),
        out: text(stdout),
        err: text(stderr),
    }
}

/// Runs the built `courier` with these arguments.
pub fn courier(arguments: &[&str]) -> Ran {
    courier_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// A folder of real data, in `$COURIER_SHARED/data` or `../shared/data`; none, and said so, where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    let shared = std::env::var_os("COURIER_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let path = shared.join("data").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!(
        "SKIPPED: nothing at {}; set COURIER_SHARED to the folder that holds data/",
        path.display()
    );
    None
}
