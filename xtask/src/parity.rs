//! The same bits on this machine and on the emulated Cortex-M4F: signal path, Givens rows, solve.

use crate::arm::{self, say};
use crate::plugin::{self, Build};
use anyhow::{Context, Result, ensure};
use cases::parity::{INPUTS, ROWS, rows, signal};
use cases::setups::Setup;
use cases::{PACKED, UNKNOWNS};
use courier_sensor::lsq::Estimator;

/// Compares digests of every bit over all generated inputs.
///
/// # Errors
/// The first one that differs, with both.
pub fn check() -> Result<()> {
    let image = plugin::build_image(&arm::ensure()?, Build::Firmware)?;
    let there = plugin::run_image(&image, &["parity"])?;
    let compare = |name: &str, here: u64| -> Result<()> {
        let line = there.lines().find_map(|line| line.strip_prefix(name));
        let found = line
            .with_context(|| format!("parity: the image said nothing of {name}"))?
            .trim();
        let here = format!("{here:016x}");
        ensure!(
            found == here,
            "parity: {name}: found {found} on the Cortex-M4F, wanted {here} as here"
        );
        Ok(())
    };
    for setup in Setup::ALL {
        compare(&format!("signal {setup:?}"), signal(setup))?;
    }
    let mut estimator: Box<Estimator<UNKNOWNS, PACKED>> = Box::new(Estimator::new(UNKNOWNS));
    compare("rows", rows(&mut estimator))?;
    say(&format!(
        "{INPUTS} inputs of the signal path and {ROWS} Givens rows with their solutions: the same bits"
    ));
    Ok(())
}
