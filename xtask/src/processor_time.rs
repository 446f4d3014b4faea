//! Processor time: what a step costs, whatever else the machine does.

use std::time::Duration;

/// Of all programs that this one has started and that have ended, with those that they started. Zero where the system does not tell.
pub fn of_children() -> Duration {
    let used = read();
    used.unwrap_or_default()
}

#[cfg(unix)]
fn read() -> Option<Duration> {
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::sys::time::TimeValLike;
    let used = getrusage(UsageWho::RUSAGE_CHILDREN).ok()?;
    let us = used.user_time().num_microseconds() + used.system_time().num_microseconds();
    us.try_into().ok().map(Duration::from_micros)
}

#[cfg(not(unix))]
fn read() -> Option<Duration> {
    None
}

/// What `work` returns, and the processor time of the programs that it ran.
pub fn of<R>(work: impl FnOnce() -> R) -> (R, Duration) {
    let before = of_children();
    let result = work();
    (result, of_children() - before)
}
