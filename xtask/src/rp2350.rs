//! `cargo xtask rp2350`: the example of one encoder on an RP2350 (`tools/encoder-rp2350`), compiled for its core, and known for an image by
//! the chip's ROM. Part of `cargo xtask nightly`: the chip's drivers take a minute of processor time.

use crate::arm::{self, root};
use crate::cargo::cargo;
use crate::platforms::ensure_target;
use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection};

/// A Cortex-M33 with its floating-point unit.
const TARGET: &str = "thumbv8m.main-none-eabihf";
/// Where its ROM looks for the block that says what an image is, and what it begins with: RP2350's data sheet, 5.9.1 and 5.9.5.
const LOOKED_IN: std::ops::Range<u64> = 0x1000_0000..0x1000_1000;
const BEGINS: [u8; 4] = 0xFFFF_DED3_u32.to_le_bytes();

/// Compiles it, and looks for the block.
///
/// # Errors
/// The target cannot be had, the example does not compile, or the block is not where the ROM looks for it.
pub fn check() -> Result<()> {
    ensure_target(TARGET)?;
    let output = root().join("target/encoder-rp2350");
    let words =
        "build --quiet --locked --release --manifest-path tools/encoder-rp2350/Cargo.toml --target";
    let mut command = cargo(&words.split(' ').collect::<Vec<_>>());
    command.arg(TARGET).arg("--target-dir").arg(&output);
    arm::run(&mut command)?;
    let image = output.join(TARGET).join("release/encoder-rp2350");
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
