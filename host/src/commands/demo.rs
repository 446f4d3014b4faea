//! `courier demo`: the package `courier-demo`, and the emulated board and the model of the chip beside the simulated one.

use crate::board::{Starter, chip, emulated};
use anyhow::Result;
use courier_demo::{On, demo};
use std::process::ExitCode;

pub use courier_demo::Args;

/// Demonstrates and prints.
///
/// # Errors
/// Options that make no courier, a board that cannot be had, or a recording that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let board = match args.on() {
        On::Sim => Starter::default(),
        On::Emulated => emulated::STARTER,
        On::Chip => chip::STARTER,
    };
    demo(args, board)
}
