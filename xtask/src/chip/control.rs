//! `cargo xtask chip control`: two images of embassy's drivers (`tools/chip/control`), run on the model of the chip. What they break of the
//! rules for clock, flash and pins is either the model's fault or embassy's; the check knows which are embassy's.

use super::model;
use crate::arm::{self, Arm, TARGET, root, run, say};
use anyhow::Result;
use std::path::PathBuf;
use std::process::Command;

/// The images: at a clock at which nothing may be broken, and at the fastest one.
const IMAGES: [&str; 2] = ["normal", "boosted"];

/// Builds the images and lets the model look at them.
///
/// # Errors
/// They cannot be built, or the check fails.
pub fn check() -> Result<()> {
    let images = images(&arm::ensure()?)?;
    run(Command::new(model::build()?).arg("control").args(images))
}

fn images(arm: &Arm) -> Result<[PathBuf; 2]> {
    say("building the control: embassy's drivers");
    let (folder, output) = (
        root().join("tools/chip/control"),
        root().join("target").join("control"),
    );
    let mut command = arm.cargo_in("build", &folder, &output);
    command.args(["--quiet", "--locked", "--release"]);
    command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "rust-lld");
    run(&mut command)?;
    let built = output.join(TARGET).join("release");
    Ok(IMAGES.map(|name| built.join(name)))
}
