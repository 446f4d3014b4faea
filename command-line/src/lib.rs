//! What the host's commands have in common.
//!
//! [`run`] takes a command line apart and turns what a command did into an exit code, [`terminal`] is all that commands print
//! with, [`destination`] is where a recording goes.

pub mod destination;
mod outcome;
pub mod terminal;

pub use outcome::{EXIT_BAD_INPUT, refuse, run};
