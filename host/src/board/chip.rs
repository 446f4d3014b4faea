//! The image as it ships on a model of its chip: a program of its own (`tools/chip`), which is not part of this command and is started
//! beside it.

use super::emulated;
use anyhow::{Result, ensure};
use board_link::Starter;
use hal_sim::board::SharedFlash;
use hal_sim::world::World;
use link_host::chip::Chip;
use std::path::{Path, PathBuf};

/// Where `cargo xtask chip` puts the model, from the project's root.
const MODEL: &str = "target/checked/chip";

/// Switches the board of this courier on.
///
/// # Errors
/// The model or the image is not built, or the image does not run.
pub fn start(world: World, flash: SharedFlash) -> Result<Chip> {
    let (model, image) = (model()?, image()?);
    Chip::start(&model, &image, world, flash)
}

/// Switches the board of a courier that is there already on.
pub const STARTER: Starter = Starter(|world, flash| Ok(Box::new(start(world, flash)?)));

/// The model's program.
fn model() -> Result<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let own = root.unwrap_or(Path::new(".")).join(MODEL);
    built("MODEL", own)
}

/// The image that the board runs.
///
/// # Errors
/// It is not built.
pub fn image() -> Result<PathBuf> {
    built("IMAGE", emulated::built("g474.elf"))
}

/// A file that the environment names, or the one that is built here.
fn built(which: &str, own: PathBuf) -> Result<PathBuf> {
    let named = std::env::var_os(format!("COURIER_CHIP_{which}"));
    let path = named.map_or(own, PathBuf::from);
    ensure!(
        path.is_file(),
        "--chip: found no {}, wanted it: `cargo xtask setup chip` builds the model and the image",
        path.display()
    );
    Ok(path)
}
