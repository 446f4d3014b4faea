//! The checks on the Cortex-M4F: the library builds for it, answers bit for bit as here, and costs no more than it may.

use crate::arm::{ensure, ensure_program, run, say};
use crate::{bench, parity};
use anyhow::Result;

/// What `cargo xtask test` asks of the target.
///
/// # Errors
/// The first check that fails.
pub fn check() -> Result<()> {
    let arm = ensure()?;
    ensure_program("qemu-system-arm", &["qemu-system-arm"])?;
    say("the library builds for the target");
    run(arm.cargo("build").args([
        "--quiet",
        "--release",
        "--package",
        "courier-sensor",
        "--lib",
    ]))?;
    parity::check()?;
    bench::check()
}
