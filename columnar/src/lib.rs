//! Parquet files: a recording as one of them, tables for other programs, and logs that other programs wrote.
//!
//! `schema` chooses how each column is stored, `decimal` finds numbers of few digits, `noise` tells how few bits
//! numbers can take, `write` writes, `values` takes any file's columns as numbers and words, `read` makes a
//! recording of them and says what a file of another program lacks, `log` makes a log that `convert` takes, `guard` turns what
//! the library does with a spoilt file into an error.
//!
//! Only the library's typed columns are used: Arrow would take minutes to compile, and adds nothing to columns of numbers.

mod decimal;
mod guard;
mod log;
mod noise;
mod read;
mod schema;
pub mod table;
mod values;
mod write;

pub use log::log;
pub use noise::{BY_ANY_FORM, BY_PARQUET, least_bits};
pub use read::{is_recording, read};
pub use write::{check_existing, write, write_compact};

/// Key of the text of the `recording.toml` in a file's metadata.
const META_KEY: &str = "recording.toml";
