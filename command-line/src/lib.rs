//! What the host's commands have in common.
//!
//! [`run`] takes a command line apart and turns what a command did into an exit code, [`parse_from`] and [`told`] are its two ends for other programs, [`program_error`] is what becomes of a panic,
//! [`terminal`] is all that commands print
//! with, [`json`] is what `--json` means in each, [`output`] writes files and keeps them from replacing what they must not,
//! [`destination`] is where a recording goes, [`recordings`] reads one in whichever form.

pub mod destination;
pub mod json;
mod outcome;
pub mod output;
pub mod program_error;
pub mod recordings;
pub mod terminal;

pub use outcome::{EXIT_BAD_INPUT, parse_from, refuse, run, told};
