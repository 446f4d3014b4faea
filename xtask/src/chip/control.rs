//! `cargo xtask chip control`: an image of embassy's drivers (`tools/chip/control`), run on the model of the chip. What it breaks of the
//! rules for clock, flash and pins is either the model's fault or embassy's; the check knows which are embassy's.

use super::model;
use crate::arm::{self, Arm, TARGET, root, run, say};
use anyhow::Result;
use std::path::PathBuf;
use std::process::Command;

/// Builds the image and lets the model look at it.
///
/// # Errors
/// It cannot be built, or the check fails.
pub fn check() -> Result<()> {
    let image = image(&arm::ensure()?)?;
    run(Command::new(model::build()?).arg("control").arg(image))
}

fn image(arm: &Arm) -> Result<PathBuf> {
    say("building the control: embassy's drivers");
    let (folder, output) = (
        root().join("tools/chip/control"),
        root().join("target").join("control"),
    );
    let mut command = arm.cargo_in("build", &folder, &output);
    command.args(["--quiet", "--locked", "--release"]);
    command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "rust-lld");
    run(&mut command)?;
    Ok(output.join(TARGET).join("release").join("control"))
}
