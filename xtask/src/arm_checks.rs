//! The checks on the Cortex-M4F: the library compiles for it, answers bit for bit as here, and costs no more than it may.

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
    say("the library compiles for the target without any board's feature");
    run(arm
        .cargo("check")
        .args(["--quiet", "--package", "courier-sensor", "--lib"]))?;
    parity::check()?;
    bench::check()
}
