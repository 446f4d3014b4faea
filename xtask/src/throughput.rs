//! Throughput on the host, beside nalgebra's QR: what replay, simulation and diagnosis have to spend.

use crate::arm;
use crate::cargo::cargo;
use anyhow::Result;

/// Builds and runs the host's benchmarks.
///
/// # Errors
/// They cannot be built or run.
pub fn run() -> Result<()> {
    arm::run(&mut cargo(&[
        "bench",
        "--quiet",
        "--package",
        "courier",
        "--bench",
        "throughput",
    ]))
}
