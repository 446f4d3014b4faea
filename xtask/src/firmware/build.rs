//! Builds an image.

use crate::arm::{self, Arm, TARGET, root, run, say, target_dir};
use crate::assemble;
use crate::permission;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Version of the linker wrapper that puts the stack below everything else.
const FLIP_LINK: &str = "0.1.12";

/// Builds an image and returns its file.
///
/// # Errors
/// The compiler's.
pub fn build(arm: &Arm, name: &str) -> Result<PathBuf> {
    say(&format!("building the {name} image"));
    build_in(arm, name, &root(), &target_dir())
}

/// The same as [`build`] of a copy of the project that lies in `folder`, built under `output`; says nothing of it.
///
/// # Errors
/// The compiler's.
pub fn build_in(arm: &Arm, name: &str, folder: &Path, output: &Path) -> Result<PathBuf> {
    let linker = flip_link()?;
    let mut command = arm.cargo_in("rustc", folder, output);
    command.args(["--quiet", "--profile", "firmware", "--bin", name]);
    if name == "emulated" {
        command.current_dir(folder.join("emulated"));
    } else {
        command.args(["--package", "courier-sensor", "--features", name]);
    }
    // Of this program alone. As cargo's own setting it would be every package's: those that images with another linker share would be
    // built anew each time.
    command.args(["--", "-C"]);
    command.arg(format!("linker={}", linker.display()));
    run(&mut command)?;
    let linked = output.join(TARGET).join("firmware").join(name);
    match name {
        "g474" => assemble::assemble(arm, &linked, folder, output),
        _ => Ok(linked),
    }
}

/// Where it is installed if it is not on the PATH.
fn own_linker() -> PathBuf {
    root().join("target/tools/bin/flip-link")
}

/// What [`build`] would run to get the linker; nothing if it is there.
pub fn missing_linker() -> Option<String> {
    let there = arm::on_path("flip-link") || own_linker().is_file();
    (!there).then(|| format!("cargo install flip-link {FLIP_LINK}, under target/tools"))
}

/// flip-link: the linker that puts the stack at RAM's lower end, so that one that runs over faults instead of overwriting.
fn flip_link() -> Result<PathBuf> {
    if arm::on_path("flip-link") {
        return Ok("flip-link".into());
    }
    let folder = root().join("target").join("tools");
    let program = own_linker();
    if !program.is_file() {
        permission::wanted("flip-link")?;
        say(&format!("cargo install flip-link {FLIP_LINK}"));
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command
            .args([
                "install",
                "--quiet",
                "--locked",
                "flip-link",
                "--version",
                FLIP_LINK,
                "--root",
            ])
            .arg(&folder);
        run(&mut command)?;
    }
    Ok(program)
}
