//! The example of one encoder on an RP2350 (`tools/encoder-rp2350`), compiled, and known for an image by the chip's ROM.
//!
//! In every `cargo xtask test` for the core of the sensor board, whose instructions the RP2350's Cortex-M33 has all of, and whose compiler is
//! there for the image: what the example shares with the other one (`tools/chip/control`) is then built once. `cargo xtask rp2350`, part of
//! `cargo xtask nightly`, for its own core.

use crate::arm::{self, root, run};
use crate::cargo::cargo;
use crate::platforms::ensure_target;
use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection};
use std::path::Path;

const FOLDER: &str = "tools/encoder-rp2350";
/// A Cortex-M33 with its floating-point unit.
const OWN: &str = "thumbv8m.main-none-eabihf";
/// Where its ROM looks for the block that says what an image is, and what it begins with: RP2350's data sheet, 5.9.1 and 5.9.5.
const LOOKED_IN: std::ops::Range<u64> = 0x1000_0000..0x1000_1000;
const BEGINS: [u8; 4] = 0xFFFF_DED3_u32.to_le_bytes();

/// Compiles it for the sensor board's core, and looks for the block.
///
/// # Errors
/// There is no compiler, the example does not compile, or the block is not where the ROM looks for it.
pub fn check() -> Result<()> {
    run(&mut arm::ensure()?.example(FOLDER))?;
    look_at(&arm::examples())
}

/// The same for its own core.
///
/// # Errors
/// As [`check`]; the core's library cannot be had.
pub fn nightly() -> Result<()> {
    ensure_target(OWN)?;
    let mut command = cargo(&["build", "--quiet", "--locked", "--profile", "checked"]);
    command.current_dir(root().join(FOLDER));
    let output = root().join("target");
    command.args(["--target", OWN, "--target-dir"]).arg(&output);
    run(&mut command)?;
    look_at(&output.join(OWN).join("checked"))
}

fn look_at(built: &Path) -> Result<()> {
    let image = built.join("encoder-rp2350");
    let bytes = std::fs::read(&image).with_context(|| image.display().to_string())?;
    let file = object::File::parse(&*bytes)?;
    let block = file
        .section_by_name(".start_block")
        .context("found no block of an image")?;
    ensure!(
        LOOKED_IN.contains(&block.address()) && block.data()?.starts_with(&BEGINS),
        "found the block of an image at {:#x}, wanted it, and not empty, in {LOOKED_IN:#x?}",
        block.address()
    );
    Ok(())
}
