//! `cargo xtask chip`: the sensor board's image as it ships, run on a model of its chip (`tools/chip`).

mod control;
mod copy;
mod figures;
mod mutate;
mod mutations;

pub use figures::json;

use crate::arm::{self, root, run, say};
use crate::cargo::cargo;
use crate::firmware;
use crate::permission::NotSetUp;
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Debian's package of what unicorn's bindings are made with.
const LIBCLANG: &str = "libclang-dev";

/// The command. Words: names of checks; none: all, and the model's own tests before them. `--mutate` and names of mutations, none:
/// all, and the model's own tests before them. `--tests` and names of tests of the emulated board, none: those of [`TESTS`].
/// `control`: embassy's image.
///
/// # Errors
/// The image or the model cannot be built, or a check fails.
pub fn run_command(arguments: &[String]) -> Result<()> {
    prepare().map_err(|error| NotSetUp::of(error, " chip"))?;
    match arguments.split_first() {
        Some((first, names)) if first == "--mutate" => mutate_all(names),
        Some((first, [])) if first == "control" => control::check(),
        Some((first, names)) if first == "--tests" => boards_tests(names),
        _ => check(arguments),
    }
}

fn check(names: &[String]) -> Result<()> {
    let image = firmware::build(&arm::ensure()?, "g474")?;
    if names.is_empty() {
        own_tests()?;
    }
    run(Command::new(build()?).arg(image).args(names))
}

fn mutate_all(names: &[String]) -> Result<()> {
    // They hold that no rule is without a fault that trips it.
    if names.is_empty() {
        own_tests()?;
    }
    let arm = arm::ensure()?;
    firmware::build(&arm, "g474")?;
    let model = build()?;
    say("each mended fault is brought in again");
    mutate::judge(mutate::run(&arm, &model, names)?)
}

/// Faults that `cargo xtask test` brings in again: one that the peripherals show, one of the signal path.
const SAMPLE: [&str; 2] = ["1-data-cache", "3-missed-instants"];

/// What `cargo xtask test` asks of the model: all checks, and that it still sees faults.
///
/// # Errors
/// As [`run_command`].
pub fn test() -> Result<()> {
    run_command(&[])?;
    mutate_all(&SAMPLE.map(Into::into))
}

/// Tests of the emulated board (`host/tests/emulated`) that need nothing which only that board has.
const TESTS: [&str; 9] = [
    "bytes::",
    "parts::a_silent_converter",
    "parts::a_stuck_channel",
    "parts::an_absent_motion_controller",
    "restarts::a_restart_under_stream",
    "storage::both_slots_torn",
    "storage::a_flash_that_does_not_erase",
    "map::",
    "log::what_is_no_image",
];

/// Those tests on the model of the chip.
fn boards_tests(names: &[String]) -> Result<()> {
    let image = firmware::build(&arm::ensure()?, "g474")?;
    let model = build()?;
    let mut command = cargo(&["test", "--profile", "checked", "--package", "courier"]);
    command.args(["--test", "emulated", "--"]);
    match names {
        [] => command.args(TESTS),
        names => command.args(names),
    };
    command
        .env("COURIER_TEST_BOARD", "chip")
        .env("COURIER_CHIP_MODEL", model)
        .env("COURIER_CHIP_IMAGE", image);
    run(&mut command)
}

fn own_tests() -> Result<()> {
    say("the chip's model: its own tests");
    run(&mut model("test"))
}

/// What is missing here, as the commands that bring it.
pub fn missing() -> Vec<String> {
    let cmake = (!arm::on_path("cmake")).then(|| "apt-get install cmake".to_owned());
    let libclang = (!has_libclang()).then(|| format!("apt-get install {LIBCLANG}"));
    cmake.into_iter().chain(libclang).collect()
}

/// Installs what is missing and builds the model and the image.
///
/// # Errors
/// Something cannot be installed or built.
pub fn set_up() -> Result<()> {
    prepare()?;
    firmware::build(&arm::ensure()?, "g474")?;
    build().map(drop)
}

/// Builds the model; its program.
fn build() -> Result<PathBuf> {
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
