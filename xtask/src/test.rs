//! `cargo xtask test`: formatting, manifests, names of effects, lints, documentation, every test of the workspace, the library on the target, both images
//! against their limits, the image as it ships on a model of its chip, an example for another chip, the reports in a browser.
//! With names of checks: these alone, one after the other.
//!
//! All tests run in the profile `checked` (Cargo.toml): optimised, since they simulate for minutes otherwise, and
//! with the overflow checks and debug assertions of a debug build. The last line is `N passed, N failed`.
//!
//! The tests run in one line and every other check in a second one beside it ([`Lane`]): many of the checks are one program, which
//! leaves a processor idle.

use crate::cargo::cargo;
use crate::runner::Which;
use crate::{
    arm, arm_checks, chip, circles, constants, firmware, manifests, mcap, names, onboard, parquet,
    platforms, processor_time, python, report, rp2350, runner,
};
use anyhow::{Context, Result, bail, ensure};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

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

/// Which of the two lines of checks, which run side by side, a check stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lane {
    /// Programs of many tests, which fill every processor.
    Tests,
    /// Everything else, in a process of its own.
    Beside,
}

/// A check: the name that `cargo xtask test NAME` takes, its line, and what it does.
type Check = (&'static str, Lane, fn() -> Tally);

/// All checks, in their order. A further one is a line here.
const CHECKS: &[Check] = &[
    ("tests", Lane::Tests, tests),
    ("emulated", Lane::Tests, emulated),
    ("formatting", Lane::Beside, || {
        component("rustfmt", "fmt");
        step("formatting", cargo(&["fmt", "--all", "--check"]))
    }),
    ("manifests", Lane::Beside, || {
        checked("manifests", manifests::check)
    }),
    ("names", Lane::Beside, || {
        checked("effects are named in their own files alone", names::check)
    }),
    ("circles", Lane::Beside, || {
        checked("circles among files", circles::check)
    }),
    ("constants", Lane::Beside, || {
        checked("the list of constants is fresh", constants::check)
    }),
    ("lints", Lane::Beside, lints),
    ("examples", Lane::Beside, || {
        let words = "test --workspace --profile checked --doc --quiet";
        let words: Vec<&str> = words.split(' ').collect();
        step("examples in the documentation", cargo(&words))
    }),
    ("documentation", Lane::Beside, documentation),
    ("python", Lane::Beside, || {
        checked("the Python package, by its wheel", python::check)
    }),
    ("report", Lane::Beside, || {
        checked("reports in a browser", || report::run(&[]))
    }),
    ("arm", Lane::Beside, || {
        checked("the Cortex-M4F", arm_checks::check)
    }),
    ("firmware", Lane::Beside, || {
        checked("flash, RAM and stack of both images", || {
            firmware::run_command(&[])
        })
    }),
    ("chip", Lane::Beside, || {
        checked("the image as it ships on a model of its chip", chip::test)
    }),
    ("rp2350", Lane::Beside, || {
        checked("the example on an RP2350", rp2350::check)
    }),
];

/// Runs every check, or those that are named, also after one has failed.
///
/// # Errors
/// At least one check failed; a name is no check's.
pub fn run(names: &[String]) -> Result<()> {
    let is_known = |name: &&String| CHECKS.iter().any(|(known, ..)| known == name);
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        let known: Vec<&str> = CHECKS.iter().map(|(name, ..)| *name).collect();
        bail!("found {unknown:?}, wanted one of {}", known.join(", "));
    }
    crate::permission::grant();
    let total = match names {
        [] => all()?,
        _ => in_turn(|name, _| names.iter().any(|wanted| wanted == name)),
    };
    let used = processor_time::of_children().as_secs_f64();
    println!("{:.1} minutes of processor time", used / 60.0);
    println!("{} passed, {} failed", total.passed, total.failed);
    ensure!(total.failed == 0, "{} failed", total.failed);
    Ok(())
}

/// The chosen checks one after the other.
fn in_turn(is_chosen: impl Fn(&str, Lane) -> bool) -> Tally {
    let mut total = Tally::default();
    for (_, _, check) in CHECKS
        .iter()
        .filter(|(name, lane, _)| is_chosen(name, *lane))
    {
        total.add(check());
    }
    total
}

/// Both lines side by side. What the second one says is shown once it has ended.
fn all() -> Result<Tally> {
    // Before either line: only one program at a time can install.
    arm::ensure()?;
    arm::ensure_program("qemu-system-arm", &["qemu-system-arm"])?;
    let log = arm::root().join("target/checks-beside.log");
    let mut beside = start_beside(&log)?;
    let mut total = in_turn(|_, lane| lane == Lane::Tests);
    let ended = beside.wait().context("the checks beside the tests")?;
    let said = std::fs::read_to_string(&log).with_context(|| log.display().to_string())?;
    print!("{said}");
    let counted = said.lines().filter_map(last_line).next_back();
    // A process that ended without its last line has failed.
    let tally = counted.unwrap_or(Tally::one(false));
    total.add(tally);
    if !ended.success() && tally.failed == 0 {
        total.failed += 1;
    }
    Ok(total)
}

/// Starts the second line: this program again, with the names of its checks. Its output goes to `log`.
fn start_beside(log: &std::path::Path) -> Result<Child> {
    let names = CHECKS
        .iter()
        .filter(|(_, lane, _)| *lane == Lane::Beside)
        .map(|(name, ..)| *name);
    if let Some(folder) = log.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let file = File::create(log).with_context(|| log.display().to_string())?;
    Command::new(std::env::current_exe()?)
        .arg("test")
        .args(names)
        .stdin(Stdio::null())
        .stderr(file.try_clone()?)
        .stdout(file)
        .spawn()
        .context("the checks beside the tests")
}

/// The numbers of this program's last line, `3 passed, 0 failed`.
fn last_line(line: &str) -> Option<Tally> {
    let (passed, failed) = line.strip_suffix(" failed")?.split_once(" passed, ")?;
    Some(Tally {
        passed: passed.parse().ok()?,
        failed: failed.parse().ok()?,
    })
}

/// Lints of all that compiles, a warning being a failure.
fn lints() -> Tally {
    component("clippy", "clippy");
    // With the code of the features, which nothing else compiles. What stands in for it without them is compiled by the tests.
    let mut total = step(
        "lints",
        clippy(
            "--workspace --all-targets --features courier/probe-code,courier/parquet,courier-python/module",
        ),
    );
    // Not among all targets, since a bare `cargo test` leaves it out.
    total.add(step(
        "lints of the emulated board's and the chip's tests",
        clippy("--workspace --test emulated --test chip --features courier/probe-code,courier/parquet,courier-python/module"),
    ));
    total
}

/// The documentation of every package, a warning being a failure. In the profile and with the features of the lints, whose
/// dependencies it needs, and with their compiler: cargo takes the workspace's own packages as the lints have checked them.
fn documentation() -> Tally {
    let mut command = cargo(&["doc", "--workspace", "--no-deps", "--quiet"]);
    command.args([
        "--profile",
        "checked",
        "--features",
        "courier/probe-code,courier/parquet,courier-python/module",
    ]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    // As `cargo clippy` sets them. Where they differ, the packages are checked once more and the documentation is the same.
    if let Ok(driver) = arm::sysroot().map(|root| root.join("bin/clippy-driver"))
        && driver.is_file()
    {
        command.env("RUSTC_WORKSPACE_WRAPPER", driver);
        let end = "__CLIPPY_HACKERY__";
        command.env(
            "CLIPPY_ARGS",
            DENIED.map(|word| word.to_owned() + end).concat(),
        );
    }
    step("documentation", command)
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

/// What clippy is told.
const DENIED: [&str; 2] = ["-D", "warnings"];

/// Clippy over what the words of `chosen` name; a warning fails it.
fn clippy(chosen: &str) -> Command {
    let mut command = cargo(&["clippy"]);
    command.args(chosen.split(' '));
    command.args(["--profile", "checked", "--"]).args(DENIED);
    command
}

fn step(name: &str, mut command: Command) -> Tally {
    say(name);
    let begin = Begin::now();
    let passed = command.status().is_ok_and(|status| status.success());
    say_done(name, passed, begin);
    Tally::one(passed)
}

/// Every test of the workspace; a build that fails counts as one failure.
fn tests() -> Tally {
    say("tests: unit, property, simulated board, the built command end to end");
    let begin = Begin::now();
    let outcome = runner::run(Which::Ordinary);
    if let Err(error) = &outcome {
        say(&format!("{error:#}"));
    }
    let (passed, failed) = outcome.unwrap_or((0, 1));
    say_done("tests", failed == 0, begin);
    Tally { passed, failed }
}

/// `cargo xtask nightly`: the tests that every change leaves out for their length, and the systems that it leaves out.
///
/// # Errors
/// They do not compile, or one has failed.
pub fn nightly() -> Result<()> {
    platforms::check()?;
    let (passed, failed) = runner::run(Which::Nightly)?;
    ensure!(passed > 0, "found no test that is left out for its length");
    let emulated = on_emulated_board(Which::Nightly);
    let faults = checked("faults brought in again", chip::nightly);
    let parquet = checked("the command with Parquet", parquet::nightly);
    let ray = checked("the examples on Ray", python::on_ray);
    let mcap = checked("the command with MCAP", mcap::nightly);
    let rp2350 = checked(
        "the example on an RP2350, for its own core",
        rp2350::nightly,
    );
    let checks = [emulated, faults, parquet, ray, mcap, rp2350];
    let failed = failed + checks.iter().map(|check| check.failed).sum::<u64>();
    ensure!(failed == 0, "{failed} failed");
    Ok(())
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
    let begin = Begin::now();
    let outcome = check();
    if let Err(error) = &outcome {
        say(&format!("{error:#}"));
    }
    say_done(name, outcome.is_ok(), begin);
    Tally::one(outcome.is_ok())
}

/// The firmware's image on the emulated board, under every fault.
fn emulated() -> Tally {
    on_emulated_board(Which::Ordinary)
}

/// The same, or its tests that every change leaves out.
fn on_emulated_board(which: Which) -> Tally {
    say("the image on the emulated board: faults, power cuts, everything at once");
    let begin = Begin::now();
    let words = [&["--test-threads=2"], which.words()].concat();
    let outcome = onboard::command(&words).and_then(|mut command| counted(&mut command));
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

/// When a check began: by the clock on the wall, and in processor time.
#[derive(Clone, Copy, Debug)]
struct Begin {
    at: Instant,
    used: Duration,
}

impl Begin {
    fn now() -> Self {
        Self {
            at: Instant::now(),
            used: processor_time::of_children(),
        }
    }
}

fn say_done(name: &str, passed: bool, begin: Begin) {
    let word = if passed { "passed" } else { "FAILED" };
    let used = processor_time::of_children().saturating_sub(begin.used);
    eprintln!(
        "test: {name}: {word} in {:.0} s, {:.0} s of processor time",
        begin.at.elapsed().as_secs_f64(),
        used.as_secs_f64()
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

    #[test]
    fn the_second_line_of_checks_is_counted_by_its_last_line() {
        let tally = Some(Tally {
            passed: 10,
            failed: 1,
        });
        assert_eq!(last_line("10 passed, 1 failed"), tally);
        assert_eq!(last_line("693 tests passed, 7 failed, 2 ignored"), None);
        assert_eq!(last_line("test: lints: passed in 3 s"), None);
    }

    #[test]
    fn every_check_has_a_name_of_its_own() {
        let mut names: Vec<&str> = CHECKS.iter().map(|(name, ..)| *name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), CHECKS.len());
    }
}
