//! The program that models the chip (`tools/chip`): what it is built with, its own tests, and its rules.

use crate::arm::{self, output, root, run, say};
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Debian's package of what unicorn's bindings are made with.
const LIBCLANG: &str = "libclang-dev";

/// Runs them.
///
/// # Errors
/// One fails.
pub fn own_tests() -> Result<()> {
    say("the chip's model: its own tests");
    run(&mut model("test"))
}

/// Names of its rules.
///
/// # Errors
/// The program cannot be run.
pub fn rules(program: &Path) -> Result<Vec<String>> {
    let said = output(Command::new(program).arg("rules"))?;
    let names = said
        .lines()
        .filter_map(|line| line.split_whitespace().next());
    Ok(names.map(ToOwned::to_owned).collect())
}

/// Names of the tests of its rules, with their modules.
///
/// # Errors
/// They cannot be built.
pub fn tests_of_rules() -> Result<Vec<String>> {
    let said =
        output(model("test").args(["--test", "rules", "--", "--list", "--format", "terse"]))?;
    let names = said.lines().filter_map(|line| line.strip_suffix(": test"));
    Ok(names.map(ToOwned::to_owned).collect())
}

/// What is missing here, as the commands that bring it.
pub fn missing() -> Vec<String> {
    let cmake = (!arm::on_path("cmake")).then(|| "apt-get install cmake".to_owned());
    let libclang = (!has_libclang()).then(|| format!("apt-get install {LIBCLANG}"));
    cmake.into_iter().chain(libclang).collect()
}

/// Builds it; the program.
///
/// # Errors
/// The compiler's.
pub fn build() -> Result<PathBuf> {
    say("building the chip's model");
    run(&mut model("build"))?;
    Ok(root().join("target").join("checked").join("chip"))
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
///
/// # Errors
/// Something cannot be installed.
pub fn prepare() -> Result<()> {
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
