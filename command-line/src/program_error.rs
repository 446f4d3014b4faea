//! An error of the program itself: a panic anywhere in a command becomes one line and an exit code of its own.
//!
//! The line holds what the authors want to know: where the panic was and what it said, the version, the system, and the command as
//! it was typed. A backtrace is never printed. Work is unwound, so that what was not finished is not left behind.

use crate::terminal::one_line;
use std::any::Any;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Mutex, PoisonError};

/// Exit code of an error of the program: `EX_SOFTWARE` of BSD's sysexits.h.
pub const EXIT_PROGRAM_ERROR: u8 = 70;

/// Where the first panic of the process was, and what it said. A panic in a helper thread is followed by another one in the thread
/// that waits for it: the first one is the cause.
static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// Does the work; `Err` with the place and the text of the panic that ended it. Panics print nothing meanwhile.
///
/// # Errors
/// The work, or a thread that it waited for, panicked.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let usual = take_hook();
    set_hook(Box::new(remember));
    // What the work has changed is not looked at again after a panic.
    let done = catch_unwind(AssertUnwindSafe(work));
    set_hook(usual);
    let first = FIRST.lock().unwrap_or_else(PoisonError::into_inner).take();
    done.map_err(|thrown| first.unwrap_or_else(|| said(thrown.as_ref()).to_owned()))
}

/// The line for a panic: where it was, in which program, on which system, by which command.
#[must_use]
pub fn told(panic: &str, program: &str, arguments: &[String]) -> String {
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    one_line(&format!(
        "error of the program, not of its input: {panic}; please report this line: {program} on {system} {processor}, command `{}`",
        arguments.join(" ")
    ))
}

fn remember(panic: &PanicHookInfo) {
    let place = panic.location().map_or_else(String::new, |location| {
        format!("{}:{}: ", from_package(location.file()), location.line())
    });
    let text = format!("{place}{}", said(panic.payload()));
    let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
    first.get_or_insert(text);
}

/// A source file's path from its package on: what lies before it is the machine's that built it.
fn from_package(path: &str) -> &str {
    let slashed = |at: &str| path.find(at).map(|start| start + at.len());
    // `…/registry/src/INDEX/PACKAGE-1.2.3/src/…` of what others wrote.
    let index = slashed("/registry/src/").or_else(|| slashed("\\registry\\src\\"));
    let behind = index.map(|start| &path[start..]);
    behind
        .and_then(|rest| rest.split_once(['/', '\\']))
        .map_or(path, |(_, package)| package)
}

/// What a panic said.
pub fn said(thrown: &(dyn Any + Send)) -> &str {
    let text = thrown.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| thrown.downcast_ref::<&str>().copied())
        .unwrap_or("no text")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_is_told_without_the_folders_of_the_machine_that_built() {
        let theirs = "/home/x/.cargo/registry/src/index-1/nalgebra-0.35.0/src/base/view.rs";
        assert_eq!(from_package(theirs), "nalgebra-0.35.0/src/base/view.rs");
        assert_eq!(from_package("diagnosis/src/lib.rs"), "diagnosis/src/lib.rs");
    }

    #[test]
    fn the_line_says_all_that_a_report_needs_and_is_one() {
        let arguments = ["courier", "diagnose", "a\nb"].map(str::to_owned);
        let line = told("x.rs:3: index\nout", "courier 1.2.3", &arguments);
        for part in ["x.rs:3: index", "courier 1.2.3", "diagnose a b"] {
            assert!(line.contains(part), "{line}");
        }
        assert!(!line.contains('\n'));
    }
}
