//! Runs every test of the workspace, each in a process of its own, as many at once as there are processors.
//!
//! `cargo test` runs one test program after the other, and many of them hold one test that takes long: a processor waits for it.
//! Here all tests of all programs stand in one line. Nothing is shared between the tests of a program, so nothing is made twice.

use crate::arm;
use crate::cargo::cargo;
use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::Duration;
use wait4::Wait4;

/// Packages whose tests take longest: they stand first in the line, so that none of them is left over at the end.
const LONGEST: [&str; 2] = ["diagnosis", "courier"];

/// A test program.
#[derive(Clone, Debug)]
struct Program {
    path: PathBuf,
    /// Folder of its package, in which its tests run.
    folder: PathBuf,
    package: String,
    /// As cargo names it.
    target: String,
}

/// One test.
#[derive(Clone, Debug)]
struct Test {
    program: Program,
    name: String,
}

/// What came of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Passed,
    Failed,
    Ignored,
}

/// A test that was run.
#[derive(Clone, Debug)]
struct Ran {
    /// Package, program and name.
    told: String,
    outcome: Outcome,
    /// Of the test's process and of those that it started and waited for.
    processor_time: Duration,
}

/// Tests whose processor time the summary names.
const NAMED: usize = 12;

/// The processor time of every test of the last run, below the project's folder.
const TIMES: &str = "target/test-times.txt";

/// Which tests are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Those of every change.
    Ordinary,
    /// Those that `#[ignore]` leaves out of it for their length.
    Nightly,
}

impl Which {
    /// The words that choose them, for a test program.
    pub fn words(self) -> &'static [&'static str] {
        match self {
            Self::Ordinary => &[],
            Self::Nightly => &["--ignored"],
        }
    }
}

/// Builds all tests and runs the chosen ones; numbers of those that passed and failed.
///
/// # Errors
/// They cannot be built, or a program cannot be run.
pub fn run(which: Which) -> Result<(u64, u64)> {
    let mut tests = Vec::new();
    for program in programs()? {
        tests.extend(tests_of(&program, which)?);
    }
    let rank = |test: &Test| {
        let place = LONGEST
            .iter()
            .position(|name| *name == test.program.package);
        place.unwrap_or(LONGEST.len())
    };
    tests.sort_by_key(rank);
    let ran = at_once(&tests, which)?;
    let count = |wanted| ran.iter().filter(|test| test.outcome == wanted).count() as u64;
    let (passed, failed) = (count(Outcome::Passed), count(Outcome::Failed));
    let (text, all) = (summary(&ran, NAMED), arm::root().join(TIMES));
    std::fs::write(&all, summary(&ran, ran.len())).with_context(|| all.display().to_string())?;
    println!("{text}all of them: {TIMES}");
    println!(
        "{passed} tests passed, {failed} failed, {} ignored",
        count(Outcome::Ignored)
    );
    Ok((passed, failed))
}

/// Builds the test programs.
fn programs() -> Result<Vec<Program>> {
    let mut command = cargo(&["test", "--workspace", "--profile", "checked", "--no-run"]);
    command.args(["--quiet", "--message-format", "json-render-diagnostics"]);
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .context("cargo test")?;
    let mut programs = Vec::new();
    for line in BufReader::new(child.stdout.take().context("cargo's output")?).lines() {
        let message: Value = serde_json::from_str(&line?).context("cargo's messages")?;
        programs.extend(program(&message));
    }
    ensure!(child.wait()?.success(), "the tests do not compile");
    ensure!(!programs.is_empty(), "cargo named no test program");
    Ok(programs)
}

/// The test program that a message of cargo's tells of.
fn program(message: &Value) -> Option<Program> {
    if message["profile"]["test"] != true {
        return None;
    }
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    // `path+file:///…/host#courier@0.1.0`, or `…/recording#0.1.0` where folder and package have one name.
    let identity = message["package_id"].as_str()?.rsplit_once('#')?.1;
    let package = match identity.split_once('@') {
        Some((name, _)) => name.to_owned(),
        None => folder.file_name()?.to_str()?.to_owned(),
    };
    Some(Program {
        path: message["executable"].as_str()?.into(),
        folder: folder.to_path_buf(),
        package,
        target: message["target"]["name"].as_str()?.to_owned(),
    })
}

/// A program, to be run as `cargo test` runs it.
fn command(program: &Program) -> Command {
    let mut command = Command::new(&program.path);
    command
        .current_dir(&program.folder)
        .env("CARGO_MANIFEST_DIR", &program.folder)
        .stdin(Stdio::null());
    command
}

/// The names of a program's tests.
fn tests_of(program: &Program, which: Which) -> Result<Vec<Test>> {
    let told = || program.path.display().to_string();
    let output = command(program)
        .args(["--list", "--format", "terse"])
        .args(which.words())
        .output()
        .with_context(told)?;
    ensure!(output.status.success(), "{}: {}", told(), output.status);
    let text = String::from_utf8_lossy(&output.stdout);
    let names = text.lines().filter_map(|line| line.strip_suffix(": test"));
    let test = |name: &str| Test {
        program: program.clone(),
        name: name.to_owned(),
    };
    Ok(names.map(test).collect())
}

/// Runs the tests in their order, as many at once as there are processors.
fn at_once(tests: &[Test], which: Which) -> Result<Vec<Ran>> {
    let line = Mutex::new(tests.iter());
    let next = || line.lock().ok()?.next();
    let work = || -> Result<Vec<Ran>> {
        std::iter::from_fn(next)
            .map(|test| one(test, which))
            .collect()
    };
    let workers = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let mut ran = Vec::new();
        for worker in running {
            match worker.join() {
                Ok(found) => ran.extend(found?),
                Err(_) => bail!("a thread that runs tests has ended"),
            }
        }
        Ok(ran)
    })
}

/// The processor time of all tests, and the `named` tests that took most of it.
fn summary(ran: &[Ran], named: usize) -> String {
    let mut by_time: Vec<&Ran> = ran.iter().collect();
    by_time.sort_by_key(|test| std::cmp::Reverse(test.processor_time));
    let all: Duration = ran.iter().map(|test| test.processor_time).sum();
    let mut text = format!(
        "tests: {} s of processor time; those that took most:\n",
        all.as_secs()
    );
    for test in by_time.iter().take(named) {
        text += &format!(
            "{:8.1} s  {}\n",
            test.processor_time.as_secs_f64(),
            test.told
        );
    }
    text
}

/// Runs one test; what it printed is shown if it failed.
fn one(test: &Test, which: Which) -> Result<Ran> {
    let told = || {
        format!(
            "{} {} {}",
            test.program.package, test.program.target, test.name
        )
    };
    let (mut printed, end) = std::io::pipe().with_context(told)?;
    let mut child = command(&test.program)
        .args(["--exact", &test.name, "--test-threads=1"])
        .args(which.words())
        .stdout(end.try_clone()?)
        .stderr(end)
        .spawn()
        .with_context(told)?;
    let mut text = Vec::new();
    printed.read_to_end(&mut text).with_context(told)?;
    let ended = child.wait4().with_context(told)?;
    let text = String::from_utf8_lossy(&text);
    let outcome = outcome(ended.status.success(), &text);
    match outcome {
        Outcome::Passed => println!("test {} ... ok", told()),
        Outcome::Ignored => println!("test {} ... ignored", told()),
        Outcome::Failed => {
            println!("test {} ... FAILED: {}\n{text}", told(), ended.status);
        }
    }
    Ok(Ran {
        told: told(),
        outcome,
        processor_time: ended.rusage.utime + ended.rusage.stime,
    })
}

/// What came of the one test whose program ended so and printed this. A program that ran no test has passed none.
fn outcome(success: bool, text: &str) -> Outcome {
    match success {
        true if text.contains("test result: ok. 1 passed") => Outcome::Passed,
        true if text.contains("0 passed; 0 failed; 1 ignored") => Outcome::Ignored,
        _ => Outcome::Failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_program_is_told_from_other_artefacts() {
        let message = |test: bool, id: &str| {
            json!({ "profile": { "test": test }, "manifest_path": "/p/host/Cargo.toml", "package_id": id,
                    "executable": "/p/target/x", "target": { "name": "board" } })
        };
        assert!(program(&message(false, "path+file:///p/host#courier@0.1.0")).is_none());
        let found = program(&message(true, "path+file:///p/host#courier@0.1.0")).unwrap();
        assert_eq!(
            (found.package.as_str(), found.target.as_str()),
            ("courier", "board")
        );
        let found = program(&message(true, "path+file:///p/host#0.1.0")).unwrap();
        assert_eq!(found.package, "host");
    }

    #[test]
    fn the_summary_names_what_took_most_first() {
        let ran = |told: &str, seconds| Ran {
            told: told.into(),
            outcome: Outcome::Passed,
            processor_time: Duration::from_secs(seconds),
        };
        let text = summary(&[ran("short", 2), ran("long", 40), ran("middle", 7)], 3);
        assert!(text.starts_with("tests: 49 s"), "{text}");
        let names: Vec<_> = text
            .lines()
            .skip(1)
            .filter_map(|line| line.split("  ").last())
            .collect();
        assert_eq!(names, ["long", "middle", "short"]);
    }

    #[test]
    fn only_a_test_that_ran_has_passed() {
        let text = |passed, failed, ignored| {
            format!(
                "test result: ok. {passed} passed; {failed} failed; {ignored} ignored; 0 measured; 9 filtered out"
            )
        };
        assert_eq!(outcome(true, &text(1, 0, 0)), Outcome::Passed);
        assert_eq!(outcome(true, &text(0, 0, 1)), Outcome::Ignored);
        assert_eq!(outcome(true, &text(0, 0, 0)), Outcome::Failed);
        assert_eq!(outcome(false, &text(1, 0, 0)), Outcome::Failed);
    }
}
