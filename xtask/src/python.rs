//! The Python package (`python/`): its wheel is built, installed into a fresh virtual environment, and tested there by pytest, beside the
//! command. The extension is built in the tests' profile and with their features, so that only its own crate and the interpreter's
//! bindings are new work.
//!
//! Python is looked for as `python3`, or as PYTHON says. Where there is none, or its packages cannot be had, this says so and skips; where
//! CI is set it fails.

use crate::arm::{self, root, run};
use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What builds the wheel and what tests it. The oldest that are meant to work stand in `python/pyproject.toml`.
const PACKAGES: [&str; 5] = ["maturin>=1.8,<2", "numpy", "pandas", "pyarrow", "pytest"];

/// What is done in an environment: its name, the packages beside [`PACKAGES`], the features of the wheel and the tests.
struct Job {
    name: &'static str,
    packages: &'static [&'static str],
    features: &'static str,
    tests: &'static str,
}

/// Builds, installs and tests the wheel.
///
/// # Errors
/// It does not compile, a test fails, or Python or its packages cannot be had where CI is set.
pub fn check() -> Result<()> {
    Job {
        name: "python",
        packages: &["duckdb"],
        features: "module",
        tests: "python/tests",
    }
    .run()
}

/// The examples on Ray, with a worker that is killed, and recordings in Parquet and MCAP. Part of `cargo xtask nightly`, and alone `cargo xtask ray`.
///
/// # Errors
/// As [`check`].
pub fn on_ray() -> Result<()> {
    crate::permission::grant();
    Job {
        name: "ray",
        packages: &["ray"],
        features: "parquet,mcap",
        tests: "python/nightly",
    }
    .run()
}

impl Job {
    fn run(&self) -> Result<()> {
        let folder = root().join("target").join(self.name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
        }
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let packages: Vec<&str> = PACKAGES.iter().chain(self.packages).copied().collect();
        let Some(python) = environment(&folder, self.name, &packages)? else {
            return Ok(());
        };
        let wheel = wheel(&python, &folder, self.features)?;
        run(pip(&python).args(["--no-deps", "--no-index"]).arg(wheel))?;
        let words = "build --quiet --profile checked --package courier";
        run(&mut cargo(&words.split(' ').collect::<Vec<_>>()))?;
        let words = "-m pytest --rootdir python --config-file python/pyproject.toml";
        run(Command::new(&python)
            .args(words.split(' '))
            .arg(self.tests)
            .current_dir(root())
            .env("COURIER_COMMAND", root().join("target/checked/courier"))
            // Ray keeps a token there.
            .env("HOME", &folder)
            .env("PYTHONDONTWRITEBYTECODE", "1"))
    }
}

/// A fresh environment in a folder, with packages: its interpreter. None, and that is said of `name`, where it cannot be had.
///
/// # Errors
/// It cannot be had where CI is set.
pub fn environment(folder: &Path, name: &str, packages: &[&str]) -> Result<Option<PathBuf>> {
    match made(&folder.join("environment"), packages) {
        Ok(python) => Ok(Some(python)),
        Err(error) => {
            ensure!(std::env::var_os("CI").is_none(), "{error:#}");
            eprintln!("{name}: SKIPPED, nothing of it was tested: {error:#}");
            Ok(None)
        }
    }
}

fn made(place: &Path, packages: &[&str]) -> Result<PathBuf> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let make = || {
        let made = Command::new(&python)
            .args(["-m", "venv"])
            .arg(place)
            .stdout(Stdio::null())
            .status();
        made.is_ok_and(|status| status.success())
    };
    if !make() {
        // Debian's Python comes without.
        arm::install(&["python3-venv"])?;
        ensure!(
            make(),
            "{}: found no way to make a virtual environment",
            python.display()
        );
    }
    let python = place.join("bin/python");
    run(pip(&python).args(packages)).context("packages of Python")?;
    Ok(python)
}

/// `pip install` of an environment. What is installed is used a few times, and is not compiled beforehand.
fn pip(python: &Path) -> Command {
    let mut command = Command::new(python);
    command.args(["-m", "pip", "install", "--quiet", "--no-compile"]);
    command.args(["--disable-pip-version-check", "--no-input"]);
    command
}

/// Builds the wheel with features of `python/Cargo.toml`.
fn wheel(python: &Path, folder: &Path, features: &str) -> Result<PathBuf> {
    let wheels = folder.join("wheels");
    let mut command = Command::new(python);
    let words = "-m maturin build --quiet --locked --profile checked --compatibility linux --manifest-path python/Cargo.toml";
    command
        .args(words.split(' '))
        .args(["--features", features, "--out"])
        .arg(&wheels)
        .current_dir(root());
    // Cargo's own variables of the running xtask are another package's.
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("CARGO_PKG") {
            command.env_remove(name);
        }
    }
    run(&mut command).context("the wheel")?;
    let mut found = std::fs::read_dir(&wheels)?.filter_map(|entry| Some(entry.ok()?.path()));
    found.next().context("maturin made no wheel")
}
