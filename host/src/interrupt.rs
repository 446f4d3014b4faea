//! Ctrl-C and a request to end: noted, so that a command can take away what it has begun.

use anyhow::{Context, Result, ensure};
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// Exit code of a command that was interrupted, as shells have it: 128 and the signal's number.
pub const EXIT_INTERRUPTED: u8 = 130;

static SEEN: AtomicBool = AtomicBool::new(false);

/// The user wants the command to end.
#[derive(Debug, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// From now on the first interruption is noted for [`check`]; a second one ends the process at once.
///
/// # Errors
/// The system does not allow it.
pub fn watch() -> Result<()> {
    ctrlc::set_handler(|| {
        if SEEN.swap(true, SeqCst) {
            std::process::exit(EXIT_INTERRUPTED.into());
        }
    })
    .context("interruption: wanted to be told of it")
}

/// To be called now and then.
///
/// # Errors
/// [`Interrupted`], once it was.
pub fn check() -> Result<()> {
    ensure!(!SEEN.load(SeqCst), Interrupted);
    Ok(())
}
