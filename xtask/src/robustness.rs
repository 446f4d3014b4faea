//! `cargo xtask robustness`: random recordings and cut surveys of nightly size.

use crate::cargo::cargo;
use anyhow::{Result, ensure};

/// Random recordings of a night.
const CRASHES: &str = "10000";
/// Cut surveys of a night.
const CUTS: &str = "200";

/// Runs both, or what the arguments say (those of the program itself).
///
/// # Errors
/// A recording ended in an error of the program, or effects were named that are not there.
pub fn run(arguments: &[String]) -> Result<()> {
    if !arguments.is_empty() {
        return program(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    }
    // Both are run, whatever came of the first.
    let crashes = program(&["crashes", CRASHES]);
    program(&["cuts", CUTS]).and(crashes)
}

fn program(arguments: &[&str]) -> Result<()> {
    // With the overflow checks of the tests.
    let words = "run --quiet --profile checked --package robustness --bin robustness --";
    let words: Vec<&str> = words.split(' ').chain(arguments.iter().copied()).collect();
    let status = cargo(&words).status()?;
    ensure!(
        status.success(),
        "robustness {}: {status}",
        arguments.join(" ")
    );
    Ok(())
}
