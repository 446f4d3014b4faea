//! The host's side of the courier's position sensor: the `courier` command and what it is made of.
//!
//! `cli` takes the command line apart, `commands` holds one file a command, `terminal` is all that they print with,
//! `replay` runs the firmware's signal path and estimator on recordings.

pub mod cli;
pub mod commands;
pub mod replay;
pub mod terminal;
