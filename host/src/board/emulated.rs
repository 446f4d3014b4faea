//! The emulated board at the far end of the link: the firmware's image in QEMU, its courier in this process.

use anyhow::{Context, Result, ensure};
use board_link::Starter;
use hal_sim::board::SharedFlash;
use hal_sim::spec::CourierSpec;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use link_host::emulated::{Emulated, Images, Parts};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Builds what is missing or old and switches a courier's board on.
///
/// # Errors
/// The images cannot be built, QEMU cannot be had, or the image does not come up.
pub fn start(spec: CourierSpec, seed: u64, flash: SharedFlash) -> Result<Emulated> {
    let home = spec.places.scatter_corner;
    let world = World::new(spec, ControllerConfig::TYPICAL, home, seed)?;
    Emulated::start(&images()?, Parts::new(world, flash))
}

/// Switches the emulated board of a courier that is there already on.
pub const STARTER: Starter = Starter(|world, flash| {
    let parts = Parts::new(world, flash);
    Ok(Box::new(Emulated::start(&images()?, parts)?))
});

/// Image and plugin, built where they are missing or old: cargo decides.
///
/// # Errors
/// This is not Linux, the project's source is not where this command was built, or it cannot be built.
pub fn images() -> Result<Images> {
    link_host::emulated::supported()?;
    if let (Some(firmware), Some(plugin)) = (named("FIRMWARE"), named("PLUGIN")) {
        return Ok(Images { firmware, plugin });
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the project's root")?;
    ensure!(
        root.join("Cargo.toml").is_file(),
        "--emulated: found no project at {}, wanted its source: the image is built from it",
        root.display()
    );
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .current_dir(root)
        .args(["run", "--quiet", "--package", "xtask", "--", "images"])
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .context("cargo")?;
    ensure!(
        built.status.success(),
        "--emulated: the images could not be built (see above)"
    );
    let text = String::from_utf8_lossy(&built.stdout);
    let mut paths = text.lines().map(Into::into);
    let [firmware, plugin] = [paths.next(), paths.next()]
        .map(|path| path.context("cargo xtask images: found no path, wanted two"));
    Ok(Images {
        firmware: firmware?,
        plugin: plugin?,
    })
}

/// Where an image lies once it is built.
pub fn built(name: &str) -> PathBuf {
    let target = "../target/arm/thumbv7em-none-eabihf/firmware";
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(target)
        .join(name)
}

/// An image that the environment names: one that is already built.
fn named(which: &str) -> Option<PathBuf> {
    std::env::var_os(format!("COURIER_EMULATED_{which}")).map(PathBuf::from)
}
