//! QEMU with the project's plugin: builds it, runs an image, hands back what the image printed.

use crate::arm::{self, root, run, say};
use anyhow::{Context, Result, bail, ensure};
use courier_sensor::emulation::{
    COUNTERS_BASE, QEMU, QEMU_ARGUMENTS, RAM_BASE, RAM_BYTES, RAM_OBJECT,
};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A run that takes longer has hung.
const PATIENCE: Duration = Duration::from_secs(600);

/// Builds the plugin for this machine.
///
/// # Errors
/// The compiler's.
pub fn build() -> Result<PathBuf> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let folder = root().join("target").join("plugin");
    let mut command = Command::new(cargo);
    command.current_dir(root().join("tools/m4plug"));
    command
        .args(["build", "--quiet", "--release", "--target-dir"])
        .arg(&folder);
    run(&mut command)?;
    Ok(folder.join("release").join("libm4plug.so"))
}

/// Runs an image on the emulated board, counting, and returns its standard output.
///
/// # Errors
/// QEMU cannot be started or ends without success, or the image does not end.
pub fn run_image(image: &Path, words: &[&str]) -> Result<String> {
    arm::ensure_program(QEMU, &[QEMU])?;
    let plugin = build()?;
    let ram = Ram::new()?;
    let mut semihosting = String::from("enable=on,target=native,arg=image");
    words
        .iter()
        .for_each(|word| semihosting.push_str(&format!(",arg={word}")));
    let [before, after] = RAM_OBJECT;
    let mut command = Command::new(QEMU);
    command
        .args(QEMU_ARGUMENTS)
        .arg("-object")
        .arg(format!("{before}{}{after}", ram.0.display()))
        .args(["-semihosting-config", &semihosting, "-plugin"])
        .arg(format!(
            "{},ram={},count={:#x}",
            plugin.display(),
            ram.0.display(),
            COUNTERS_BASE - RAM_BASE
        ))
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::piped());
    wait(&mut command)
}

fn wait(command: &mut Command) -> Result<String> {
    let mut child = command.spawn().context(QEMU)?;
    let mut stdout = child.stdout.take().context("qemu-system-arm: no output")?;
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        stdout.read_to_string(&mut text).map(|_| text)
    });
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if begin.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            bail!("the image did not end within {} s", PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let text = reader
        .join()
        .map_err(|_| anyhow::anyhow!("reading the image's output failed"))??;
    ensure!(
        status.success(),
        "qemu-system-arm: {status}; the image said:\n{text}"
    );
    Ok(text)
}

/// The file that backs the emulated RAM; gone when dropped.
struct Ram(PathBuf);

impl Ram {
    fn new() -> Result<Self> {
        let shared = Path::new("/dev/shm");
        let folder = if shared.is_dir() {
            shared.to_path_buf()
        } else {
            std::env::temp_dir()
        };
        let path = folder.join(format!(
            "courier-bench-{}-{:?}",
            std::process::id(),
            std::thread::current().id()
        ));
        let file = File::create(&path).with_context(|| path.display().to_string())?;
        file.set_len(RAM_BYTES as u64)?;
        Ok(Self(path))
    }
}

impl Drop for Ram {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// How the measuring image is built.
#[derive(Clone, Copy, Debug)]
pub enum Build<'a> {
    /// As the firmware's images are.
    Firmware,
    /// For speed, as peers are measured; with the CMSIS-DSP peer where that could be had.
    Speed(Option<&'a Path>),
}

/// Builds the measuring image.
///
/// # Errors
/// The compiler's.
pub fn build_image(arm: &arm::Arm, build: Build<'_>) -> Result<PathBuf> {
    let (profile, peer) = match build {
        Build::Firmware => ("firmware", None),
        Build::Speed(peer) => ("release", peer),
    };
    say(&format!("building the measuring image, profile {profile}"));
    let mut command = arm.cargo("build");
    command.current_dir(root().join("bench")).args([
        "--quiet",
        "--profile",
        profile,
        "--package",
        "image",
    ]);
    if let Some(folder) = peer {
        command
            .args(["--features", "cmsis"])
            .env("COURIER_CMSIS", folder);
    }
    run(&mut command)?;
    Ok(arm::target_dir()
        .join(arm::TARGET)
        .join(profile)
        .join("image"))
}
