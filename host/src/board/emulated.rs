//! The emulated board at the far end of the link: the firmware's image in QEMU, its courier in this process.

use anyhow::{Context, Result, bail, ensure};
use board_link::Starter;
use hal_sim::board::SharedFlash;
use hal_sim::world::World;
use link_host::emulated::{Emulated, Images, Parts};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// How a line of `cargo xtask images` begins that tells a step.
const STEP: &str = "arm: ";
/// Its exit code where something has to be installed first.
const NOT_SET_UP: i32 = 2;

/// Builds what is missing or old and switches the board of a courier that is there already on.
///
/// # Errors
/// The images cannot be built, QEMU cannot be had, or the image does not come up.
pub fn start(world: World, flash: SharedFlash) -> Result<Emulated> {
    Emulated::start(&images()?, Parts::new(world, flash))
}

/// The same for a [`board_link::Simulated`].
pub const STARTER: Starter = Starter(|world, flash| Ok(Box::new(start(world, flash)?)));

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
    let text = build(root)?;
    let mut paths = text.lines().map(Into::into);
    let [firmware, plugin] = [paths.next(), paths.next()]
        .map(|path| path.context("cargo xtask images: found no path, wanted two"));
    Ok(Images {
        firmware: firmware?,
        plugin: plugin?,
    })
}

/// Builds, tells each step on standard error, and returns what was printed. Nothing is installed: what is missing is told in the one
/// line of the refusal.
fn build(root: &Path) -> Result<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut child = Command::new(cargo)
        .current_dir(root)
        .args(["run", "--quiet", "--package", "xtask", "--", "images"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("--emulated: cargo")?;
    let mut told = Vec::new();
    if let Some(lines) = child.stderr.take() {
        for line in BufReader::new(lines).split(b'\n') {
            let line = String::from_utf8_lossy(&line?).into_owned();
            match line.strip_prefix(STEP) {
                Some(step) => eprintln!("courier: {step}"),
                None => told.push(line),
            }
        }
    }
    let done = child.wait_with_output().context("--emulated: cargo")?;
    if done.status.code() == Some(NOT_SET_UP) {
        let last = told.last().map_or("", String::as_str);
        bail!("--emulated: {}", last.trim_start_matches("xtask images: "));
    }
    told.iter().for_each(|line| eprintln!("{line}"));
    ensure!(
        done.status.success(),
        "--emulated: the images could not be built (see above)"
    );
    Ok(String::from_utf8_lossy(&done.stdout).into_owned())
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
