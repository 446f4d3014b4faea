//! The firmware's image on the emulated board: its tests, as `cargo xtask test` runs them and, at full length, `bench`.

use crate::arm;
use crate::{cargo, firmware, plugin};
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// What `bench` and `cargo xtask emulated` run at the lengths that were asked for.
const FULL: [(&str, &str); 3] = [
    ("COURIER_EMULATED_SECONDS", "60"),
    ("COURIER_FUZZ_BYTES", "10000000"),
    ("COURIER_EMULATED_POSES", "1000"),
];

/// The tests, for an image and a plugin that are built first; `words` go to the test program.
///
/// # Errors
/// They cannot be built, or QEMU cannot be had.
pub fn command(words: &[&str]) -> Result<Command> {
    arm::ensure_program("qemu-system-arm", &["qemu-system-arm"])?;
    let image = firmware::build(&arm::ensure()?, "emulated")?;
    let mut command = cargo(&["test", "--profile", "checked", "--package", "courier"]);
    command
        .args(["--test", "emulated", "--", "--test-threads=2"])
        .args(words)
        .env("COURIER_EMULATED_FIRMWARE", image)
        .env("COURIER_EMULATED_PLUGIN", plugin::build()?);
    Ok(command)
}

/// The same at full length, with what each printed.
///
/// # Errors
/// A test fails, or as [`command`].
pub fn run(words: &[String]) -> Result<()> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut command = command(&[&["--nocapture", "--test-threads=1"], &words[..]].concat())?;
    arm::run(command.envs(FULL))
}

/// Figures of the link and of the long run, as the tests print them.
///
/// # Errors
/// As [`run`].
pub fn figures() -> Result<()> {
    println!("\nthe image on the emulated board:");
    let words = ["--nocapture", "--test-threads=1", "long", "speed", "fuzzed"];
    let output = command(&words)?.envs(FULL).output().context("cargo test")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let harness = ["running ", "test result", "test ", "failures"];
    let told =
        |line: &&str| !line.is_empty() && !harness.iter().any(|start| line.starts_with(start));
    text.lines()
        .filter(told)
        .for_each(|line| println!("  {line}"));
    ensure!(output.status.success(), "a figure is not reached:\n{text}");
    Ok(())
}
