//! `cargo xtask chip`: the sensor board's image as it ships, run on a model of its chip (`tools/chip`).

use crate::arm::{self, root, run, say};
use crate::firmware;
use anyhow::{Result, ensure};
use std::path::Path;
use std::process::Command;

/// Debian's package of what unicorn's bindings are made with.
const LIBCLANG: &str = "libclang-dev";

/// The command. Words: names of checks; none: all, and the model's own tests before them.
///
/// # Errors
/// The image or the model cannot be built, or a check fails.
pub fn run_command(arguments: &[String]) -> Result<()> {
    let arm = arm::ensure()?;
    let image = firmware::build(&arm, "g474")?;
    prepare()?;
    if arguments.is_empty() {
        say("the chip's model: its own tests");
        run(&mut model("test"))?;
    }
    say("building the chip's model");
    run(&mut model("build"))?;
    let program = root().join("target").join("checked").join("chip");
    run(Command::new(program).arg(image).args(arguments))
}

/// `cargo SUBCOMMAND` in the model's own workspace; what it builds lies with the rest.
fn model(subcommand: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(root().join("tools/chip"));
    command
        .args([subcommand, "--quiet", "--locked", "--profile", "checked"])
        .arg("--target-dir")
        .arg(root().join("target"));
    command
}

/// Sets up what the crate `unicorn-engine` is built with.
fn prepare() -> Result<()> {
    arm::ensure_program("cmake", &["cmake"])?;
    if !has_libclang() {
        say("libclang is missing");
        arm::install(&[LIBCLANG])?;
        ensure!(
            has_libclang(),
            "Debian's {LIBCLANG} is installed, yet libclang is not where it should be"
        );
    }
    Ok(())
}

/// Whether libclang lies where the bindings' generator looks for it: a folder that the environment names, or Debian's.
fn has_libclang() -> bool {
    if std::env::var_os("LIBCLANG_PATH").is_some() {
        return true;
    }
    let folders = Path::new("/usr/lib").read_dir().into_iter().flatten();
    let versions = folders.flatten().map(|entry| entry.path());
    versions
        .filter(|path| path.to_string_lossy().contains("llvm"))
        .any(|path| path.join("lib/libclang.so").exists())
}
