//! Cargo, as it runs this program.

use crate::arm;
use std::process::Command;

/// `cargo` with these arguments, in the project's root.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(arm::root()).args(arguments);
    command
}
