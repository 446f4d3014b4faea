//! `cargo xtask chip control`: two images of embassy's drivers (`tools/chip/control`), run on the model of the chip. What they break of the
//! rules for clock, flash and pins is either the model's fault or embassy's; the check knows which are embassy's.

use super::model;
use crate::arm::{self, run, say};
use anyhow::Result;
use std::process::Command;

/// The images: at a clock at which nothing may be broken, and at the fastest one.
const IMAGES: [&str; 2] = ["normal", "boosted"];

/// Builds the images and lets the model look at them.
///
/// # Errors
/// They cannot be built, or the check fails.
pub fn check() -> Result<()> {
    say("building the control: embassy's drivers");
    run(&mut arm::ensure()?.example("tools/chip/control"))?;
    let images = IMAGES.map(|name| arm::examples().join(name));
    run(Command::new(model::build()?).arg("control").args(images))
}
