//! `cargo xtask test`: formatting, manifests, lints, other operating systems, documentation, every test of the workspace, the library on the target, both images
//! against their limits, the image as it ships on a model of its chip, the reports in a browser.
//!
//! All tests run in the profile `checked` (Cargo.toml): optimised, since they simulate for minutes otherwise, and
//! with the overflow checks and debug assertions of a debug build. The last line is `N passed, N failed`.

use crate::{arm, cargo, chip, firmware, manifests, onboard, platforms, report, runner};
use anyhow::{Context, Result, ensure};
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Passed and failed so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    passed: u64,
    failed: u64,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
    }

    fn one(passed: bool) -> Self {
        Self {
            passed: u64::from(passed),
            failed: u64::from(!passed),
        }
    }
}

/// Runs every check, also after one has failed.
///
/// # Errors
/// At least one check failed.
pub fn run() -> Result<()> {
    crate::permission::grant();
    let mut total = Tally::default();
    for (name, what) in [("rustfmt", "fmt"), ("clippy", "clippy")] {
        component(name, what);
    }
    total.add(step("formatting", cargo(&["fmt", "--all", "--check"])));
    total.add(checked("manifests", manifests::check));
    total.add(step("lints", clippy("--workspace --all-targets")));
    // Not among all targets, since a bare `cargo test` leaves it out.
    total.add(step(
        "lints of the emulated board's tests",
        clippy("--package courier --test emulated"),
    ));
    // Built only where asked for: nothing else would see that it no longer compiles.
    total.add(step(
        "lints of the debug probe's code",
        clippy("--package link-host --package courier --all-targets --features courier/probe"),
    ));
    total.add(checked("macOS and Windows", platforms::check));
    total.add(tests());
    let examples = [
        "test",
        "--workspace",
        "--profile",
        "checked",
        "--doc",
        "--quiet",
    ];
    total.add(step("examples in the documentation", cargo(&examples)));
    // In the profile of the lints, whose dependencies it needs.
    let mut documentation = cargo(&["doc", "--workspace", "--no-deps", "--quiet"]);
    documentation.args(["--profile", "checked"]);
    documentation.env("RUSTDOCFLAGS", "-D warnings");
    total.add(step("documentation", documentation));
    total.add(checked("reports in a browser", || report::run(&[])));
    total.add(checked("the Cortex-M4F", arm::checks));
    total.add(emulated());
    total.add(checked("flash, RAM and stack of both images", || {
        firmware::run_command(&[])
    }));
    total.add(checked(
        "the image as it ships on a model of its chip",
        chip::test,
    ));
    println!("{} passed, {} failed", total.passed, total.failed);
    ensure!(total.failed == 0, "{} failed", total.failed);
    Ok(())
}

/// Installs a component of the toolchain that is missing, where rustup can.
fn component(name: &str, subcommand: &str) {
    let there = cargo(&[subcommand, "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !there {
        say(&format!("{name} is missing: rustup component add {name}"));
        let added = Command::new("rustup")
            .args(["component", "add", name])
            .status();
        if !added.is_ok_and(|status| status.success()) {
            say(&format!("{name} cannot be added; its check will fail"));
        }
    }
}

/// Clippy over what the words of `chosen` name; a warning fails it.
fn clippy(chosen: &str) -> Command {
    let mut command = cargo(&["clippy"]);
    command.args(chosen.split(' '));
    command.args(["--profile", "checked", "--", "-D", "warnings"]);
    command
}

fn step(name: &str, mut command: Command) -> Tally {
    say(name);
    let begin = Instant::now();
    let passed = command.status().is_ok_and(|status| status.success());
    say_done(name, passed, begin);
    Tally::one(passed)
}

/// Every test of the workspace; a build that fails counts as one failure.
fn tests() -> Tally {
    say("tests: unit, property, simulated board, the built command end to end");
    let begin = Instant::now();
    let outcome = runner::run();
    if let Err(error) = &outcome {
        say(&format!("{error:#}"));
    }
    let (passed, failed) = outcome.unwrap_or((0, 1));
    say_done("tests", failed == 0, begin);
    Tally { passed, failed }
}

/// Runs `command`, shows its output as it comes, and adds up the summaries of its test programs.
fn counted(command: &mut Command) -> Result<(Tally, bool)> {
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .context("cargo test")?;
    let mut tally = Tally::default();
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).split(b'\n') {
            let line = line.context("the output of cargo test")?;
            let line = String::from_utf8_lossy(&line);
            writeln!(std::io::stdout(), "{line}").context("standard output")?;
            tally.add(summary(&line).unwrap_or_default());
        }
    }
    Ok((tally, child.wait().context("cargo test")?.success()))
}

/// The numbers of `test result: ok. 3 passed; 0 failed; …`.
fn summary(line: &str) -> Option<Tally> {
    let (_, numbers) = line.strip_prefix("test result: ")?.split_once(". ")?;
    let number = |name: &str| {
        numbers
            .split("; ")
            .find_map(|part| part.strip_suffix(name))
            .and_then(|number| number.trim().parse().ok())
    };
    Some(Tally {
        passed: number(" passed")?,
        failed: number(" failed")?,
    })
}

/// A check of this program's own.
fn checked(name: &str, check: impl FnOnce() -> Result<()>) -> Tally {
    say(name);
    let begin = Instant::now();
    let outcome = check();
    if let Err(error) = &outcome {
        say(&format!("{error:#}"));
    }
    say_done(name, outcome.is_ok(), begin);
    Tally::one(outcome.is_ok())
}

/// The firmware's image on the emulated board, under every fault.
fn emulated() -> Tally {
    say("the image on the emulated board: faults, power cuts, everything at once");
    let begin = Instant::now();
    let outcome =
        onboard::command(&["--test-threads=2"]).and_then(|mut command| counted(&mut command));
    if let Err(error) = &outcome {
        say(&format!("{error:#}"));
    }
    let (mut tally, success) = outcome.unwrap_or((Tally::default(), false));
    if !success && tally.failed == 0 {
        tally.failed = 1;
    }
    say_done("the emulated board", success, begin);
    tally
}

fn say(what: &str) {
    eprintln!("test: {what}");
}

fn say_done(name: &str, passed: bool, begin: Instant) {
    let word = if passed { "passed" } else { "FAILED" };
    eprintln!(
        "test: {name}: {word} in {:.0} s",
        begin.elapsed().as_secs_f64()
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_are_counted() {
        let line = "test result: FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.2s";
        assert_eq!(
            summary(line),
            Some(Tally {
                passed: 12,
                failed: 3
            })
        );
        assert_eq!(summary("running 3 tests"), None);
    }
}
