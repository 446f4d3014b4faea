//! The host's command type-checked for the systems that it is not built on here: macOS and Windows.
//!
//! `cargo check` needs the target's standard library, which rustup has, and neither its linker nor its headers: no dependency
//! of `courier` has code in C.

use crate::arm;
use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use std::process::{Command, Stdio};

/// One target a system.
const TARGETS: [&str; 2] = ["x86_64-pc-windows-msvc", "aarch64-apple-darwin"];

/// Checks `courier` and the demonstration for both. Part of `cargo xtask nightly` and not of every change: each system has a machine in
/// `.github/workflows/ci.yml` that runs the command, and a target costs 63 to 73 s of processor time, most of it for what others wrote.
///
/// # Errors
/// A target's standard library cannot be had, or the code does not compile for it.
pub fn check() -> Result<()> {
    let mut command = cargo(&["check", "--quiet", "--profile", "checked"]);
    command.args(["--package", "courier", "--package", "courier-demo"]);
    for target in TARGETS {
        ensure_target(target)?;
        command.args(["--target", target]);
    }
    arm::run(&mut command)
}

/// Adds a target's standard library where it is missing.
///
/// # Errors
/// rustup is not there, or has it not.
pub fn ensure_target(target: &str) -> Result<()> {
    let mut compiler = Command::new("rustc");
    compiler
        .args(["--print", "target-libdir", "--target", target])
        .current_dir(arm::root());
    let library = arm::output(&mut compiler)?;
    let is_there = || std::path::Path::new(library.trim()).is_dir();
    if is_there() {
        return Ok(());
    }
    arm::say(&format!(
        "target {target} is missing: rustup target add {target}"
    ));
    let added = Command::new("rustup")
        .args(["target", "add", target])
        .current_dir(arm::root())
        .stdout(Stdio::null())
        .status()
        .context("rustup, which has the standard library of other systems")?;
    ensure!(
        added.success() && is_there(),
        "rustup cannot add {target} here; wanted its standard library, so that the command can be checked for it"
    );
    Ok(())
}
