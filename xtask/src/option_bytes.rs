//! `cargo xtask option-bytes`: looks at the option bytes of the board behind a debug probe, says what it would set, asks, and sets it.

use crate::arm::{root, run, say};
use crate::flash::{self, NoProbe};
use anyhow::{Result, ensure};
use std::process::Command;

/// The command. Words: `--yes`, which sets without asking, and the probe's selector, as `courier --probe` takes it.
///
/// # Errors
/// [`NoProbe`], or the option bytes cannot be read or set.
pub fn run_command(arguments: &[String]) -> Result<()> {
    let selectors = arguments.iter().filter(|word| *word != "--yes").count();
    ensure!(
        selectors <= 1 && arguments.len() <= selectors + 1,
        "found {arguments:?}, wanted at most --yes and a probe's selector"
    );
    ensure!(flash::is_there_a_probe(), NoProbe);
    say("building the setter (probe-rs: some minutes, once)");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(root());
    command.args(["run", "--quiet", "--release", "--package", "link-host"]);
    command.args(["--features", "probe,chips", "--bin", "options", "--"]);
    run(command.args(arguments))
}
