//! Copies a recording, a folder or a Parquet file, to a new one: what reading and writing cost, and nothing else (`cargo xtask parquet`).
//!
//!     copy FROM TO
//!
//! A name that ends in `.parquet` is a file, another one a folder.

use recording::{Error, Existing, Recording};
use std::path::{Path, PathBuf};

fn main() -> Result<(), String> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [from, to] = paths.as_slice() else {
        return Err(format!("found {} paths, wanted FROM and TO", paths.len()));
    };
    copied(from, to).map_err(|error| error.to_string())
}

fn copied(from: &Path, to: &Path) -> Result<(), Error> {
    let is_file = |path: &Path| path.extension().is_some_and(|ending| ending == "parquet");
    let recording = match is_file(from) {
        true => columnar::read(from)?,
        false => Recording::read(from)?,
    };
    match is_file(to) {
        true => columnar::write(&recording.meta, &recording.samples, to, Existing::Refuse),
        false => recording.write(to, Existing::Refuse),
    }
}
