//! What takes long is done without the interpreter's lock, and told once the lock is held again.

use crate::error::{panicked, refused, refused_words, warn};
use anyhow::{Context, Result};
use command_line::{parse_from, program_error};
use courier::cli::Cli;
use courier::commands::Command;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A command's options from its words: as the command line has them, the program's name left out.
pub fn parsed(py: Python<'_>, command: &str, words: Vec<OsString>) -> PyResult<Command> {
    let line: Vec<OsString> = ["courier", command]
        .into_iter()
        .map(OsString::from)
        .chain(words)
        .collect();
    let cli: Cli = parse_from(&line).map_err(|line| refused_words(py, &line))?;
    Ok(cli.command)
}

/// Does the work without the lock. What it tells besides becomes warnings, in their order, and before the error where there is one.
pub fn done<T: Send>(
    py: Python<'_>,
    what: &str,
    work: impl FnOnce(&mut dyn FnMut(&str)) -> Result<T> + Send,
) -> PyResult<T> {
    let (outcome, lines) = py.detach(|| {
        let mut lines = Vec::new();
        let mut tell = |line: &str| lines.push(line.to_owned());
        // What the work has changed is not looked at again after a panic.
        let outcome = catch_unwind(AssertUnwindSafe(|| with_threads(|| work(&mut tell))));
        (outcome, lines)
    });
    for line in lines {
        warn(py, &line)?;
    }
    match outcome {
        Ok(outcome) => outcome.map_err(|error| refused(py, &error)),
        Err(thrown) => {
            let program = concat!("courier ", env!("CARGO_PKG_VERSION"), " in Python");
            let words = ["courier".to_owned(), what.to_owned()];
            let line = program_error::told(program_error::said(thrown.as_ref()), program, &words);
            Err(panicked(py, &line))
        }
    }
}

/// With threads of its own, which end with it: a process that forks, as Python's `multiprocessing` may, leaves those of others behind, and its
/// child would wait for them without end.
fn with_threads<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let threads = rayon::ThreadPoolBuilder::new().build().context("threads")?;
    threads.install(work)
}
