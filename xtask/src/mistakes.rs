//! `cargo xtask mistakes`: the nightly check of what is told of mis-wired recordings, and of right ones.

use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};

/// Any would do; a caller may give his own.
const SEED: &str = "20260101";

/// Runs every kind of mistake five times and five hundred right recordings, by a seed.
///
/// # Errors
/// A mistake is not recognised, something is told of a right recording, or the check cannot be run.
pub fn run(arguments: &[String]) -> Result<()> {
    ensure!(
        arguments.len() <= 1,
        "found {:?}, wanted at most SEED",
        arguments[1]
    );
    let seed = arguments.first().map_or(SEED, String::as_str);
    let done = cargo(&[
        "test",
        "--quiet",
        "--release",
        "--package",
        "plausibility",
        "--test",
        "mistakes",
        "--",
        "--ignored",
        "--nocapture",
    ])
    .env("PLAUSIBILITY_SEED", seed)
    .status()
    .context("the tests of plausibility")?;
    ensure!(done.success(), "not all as it should be, see above");
    Ok(())
}
