//! What the library does with a spoilt file, turned into an error.
//!
//! It checks much and answers with an error, but not everything: a spoilt length can end in arithmetic that overflows, and a spoilt place
//! beside the data's end. Such a panic is caught here and says nothing.

use parquet::errors::ParquetError;
use recording::Error;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::Once;

/// What a file should be that the library cannot read.
const WANTED: &str = "a whole Parquet file, not compressed, or by snappy or zstd";

/// Longest text of the library's that is told, characters.
const LONGEST: usize = 120;

thread_local! {
    /// Whether this thread reads a file, so that a panic is the file's fault.
    static READS: Cell<bool> = const { Cell::new(false) };
}

/// The library's own words in one line.
pub(crate) fn told(path: &Path, error: &ParquetError) -> Error {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default();
    let line: String = line
        .chars()
        .filter(|c| !c.is_control())
        .take(LONGEST)
        .collect();
    Error::new(path, format!("\"{line}\""), WANTED)
}

/// Reads a file; where the library panics over it, the file is refused.
///
/// # Errors
/// As `read`, or it panicked.
pub(crate) fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    silence();
    let before = READS.replace(true);
    // What was read is not looked at again after a panic.
    let done = catch_unwind(AssertUnwindSafe(read));
    READS.set(before);
    done.unwrap_or_else(|_| Err(Error::new(path, "spoilt bytes", WANTED)))
}

/// From now on panics of threads that read a file are not told; all others are, as before.
fn silence() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |panic| {
            if !READS.get() {
                usual(panic);
            }
        }));
    });
}
