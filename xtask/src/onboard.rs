//! The firmware's image on the emulated board: its tests, as `cargo xtask test` runs them and, at full length, `bench`.

use crate::arm;
use crate::cargo::cargo;
use crate::{firmware, plugin};
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// The tests at full length: minutes, where they have 120 poses, 12 s, a megabyte, and every fifth power cut.
const FULL: [(&str, &str); 4] = [
    ("COURIER_EMULATED_POSES", "1000"),
    ("COURIER_EMULATED_SECONDS", "60"),
    ("COURIER_FUZZ_BYTES", "10000000"),
    ("COURIER_CUT_EVERY", "1"),
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
        .args(["--test", "emulated", "--"])
        .args(words)
        .env("COURIER_EMULATED_FIRMWARE", image)
        .env("COURIER_EMULATED_PLUGIN", plugin::build()?);
    Ok(command)
}

/// The same, one after the other, with what each printed and 1000 poses of the demonstration.
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
    text.lines()
        .filter_map(figure)
        .for_each(|line| println!("  {line}"));
    ensure!(output.status.success(), "a figure is not reached:\n{text}");
    Ok(())
}

/// What a test printed, not what its harness says of it; the first line stands behind the test's name.
fn figure(line: &str) -> Option<&str> {
    let behind = line
        .strip_prefix("test ")
        .and_then(|rest| rest.split_once(" ... "));
    let line = behind.map_or(line, |(_, told)| told);
    let harness = ["running ", "test result", "ok", "FAILED"];
    (!line.is_empty() && !harness.iter().any(|start| line.starts_with(start))).then_some(line)
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_are_told_from_the_harness() {
        assert_eq!(
            figure("test long::none ... 60 s: 0 missed"),
            Some("60 s: 0 missed")
        );
        assert_eq!(figure("command: 1 ms"), Some("command: 1 ms"));
        for harness in [
            "ok",
            "",
            "running 3 tests",
            "test result: ok. 3 passed",
            "test a ... ok",
        ] {
            assert_eq!(figure(harness), None, "{harness}");
        }
    }
}
