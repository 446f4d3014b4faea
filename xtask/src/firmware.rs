//! `cargo xtask firmware`: builds both images and checks that they fit.

mod build;
mod image;
mod sizes;

pub use build::{build, build_in, missing_linker};

use self::image::{IMAGES, Image};
use crate::arm::{self, Arm};
use crate::plugin;
use anyhow::{Result, bail};
use serde_json::Value;

/// The command. Words: names of images; none: all.
///
/// # Errors
/// An image cannot be built or does not fit.
pub fn run_command(arguments: &[String]) -> Result<()> {
    let arm = arm::ensure()?;
    let chosen =
        |image: &&Image| arguments.is_empty() || arguments.iter().any(|name| name == image.name);
    if let Some(unknown) = arguments
        .iter()
        .find(|name| IMAGES.iter().all(|image| image.name != **name))
    {
        bail!("found {unknown:?}, wanted g474 or emulated");
    }
    for image in IMAGES.iter().filter(chosen) {
        let file = build(&arm, image.name)?;
        let sizes = image.measure(&file)?;
        sizes::print(image.name, &file, &sizes);
        image.check(&file, &sizes)?;
    }
    Ok(())
}

/// Sizes of both images, for the bench's JSON.
///
/// # Errors
/// As [`run_command`].
pub fn sizes(arm: &Arm) -> Result<serde_json::Map<String, Value>> {
    let measured = IMAGES.iter().map(|image| {
        let sizes = image.measure(&build(arm, image.name)?)?;
        Ok((image.name.to_owned(), sizes.json()))
    });
    measured.collect()
}

/// Builds the emulated board's image and the plugin; their paths go to standard output, one a line.
///
/// # Errors
/// The compiler's, or QEMU cannot be had.
pub fn images() -> Result<()> {
    arm::ensure_program("qemu-system-arm", &["qemu-system-arm"])?;
    let firmware = build(&arm::ensure()?, "emulated")?;
    println!("{}", firmware.display());
    println!("{}", plugin::build()?.display());
    Ok(())
}
