//! The Cortex-M4F toolchain: finds what there is, sets up what is missing, says each step on standard error.
//!
//! Two ways, tried in this order: the target's `core` from rustup, or Debian's compiler with `core` built from Debian's source.
//! Nothing that ships needs an unstable feature; the second way alone uses one, to build `core`.

use crate::permission;
use anyhow::{Context, Result, bail, ensure};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The one target: Cortex-M4 with its single-precision floating-point unit, hard-float calls.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Debian's packages of the second way.
const DEBIAN_COMPILER: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

/// Where they put it.
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// A cargo that builds for [`TARGET`].
#[derive(Clone, Debug)]
pub struct Arm {
    cargo: PathBuf,
    environment: Vec<(&'static str, OsString)>,
    build_core: bool,
}

impl Arm {
    /// `cargo SUBCOMMAND --target …`, run in the project's root, its output under `target/arm`.
    pub fn cargo(&self, subcommand: &str) -> Command {
        self.cargo_in(subcommand, &root(), &target_dir())
    }

    /// The same for a copy of the project that lies in `folder`, its output under `output`. The settings are those of the
    /// project itself, so that what others wrote and has been built for it need not be built again.
    pub fn cargo_in(&self, subcommand: &str, folder: &Path, output: &Path) -> Command {
        let mut command = Command::new(&self.cargo);
        command
            .current_dir(folder)
            .arg(subcommand)
            .args(["--target", TARGET, "--target-dir"])
            .arg(output)
            .arg("--config")
            .arg(remapped_paths());
        if self.build_core {
            command.arg("-Zbuild-std=core,alloc");
            command.env_remove("RUSTUP_TOOLCHAIN");
        }
        // Cargo's own variables of the running xtask would make the inner build see the outer one's package.
        for (name, _) in
            env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("CARGO_PKG"))
        {
            command.env_remove(name);
        }
        // It would split the image's one unit (Cargo.toml, profile `firmware`) into many: other code, a larger stack.
        command.env_remove("CARGO_INCREMENTAL");
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command
    }

    /// `cargo build` of an example that is a workspace of its own, in the tests' profile and beside them: what both are made with at
    /// compile time is built once.
    pub fn example(&self, folder: &str) -> Command {
        let mut command = self.cargo_in("build", &root().join(folder), &root().join("target"));
        command.args(["--quiet", "--locked", "--profile", "checked"]);
        command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "rust-lld");
        command
    }
}

/// Where the images of the examples are, once they are built.
pub fn examples() -> PathBuf {
    root().join("target").join(TARGET).join("checked")
}

/// Cargo's setting that shortens the paths in panic messages.
fn remapped_paths() -> String {
    let registry = env::home_dir()
        .map(|home| env::var_os("CARGO_HOME").map_or(home.join(".cargo"), PathBuf::from))
        .map(|home| home.join("registry").join("src"));
    let mut flags = vec![remap(&root(), ".")];
    // Each registry's folder is named after its address: an image is the same from whichever the crates came.
    let folders = registry
        .iter()
        .flat_map(|all| fs::read_dir(all).into_iter().flatten())
        .flatten();
    flags.extend(registry.iter().map(|all| remap(all, "registry")));
    flags.extend(folders.map(|folder| remap(&folder.path(), "registry")));
    format!("target.{TARGET}.rustflags=[{}]", flags.join(","))
}

/// This machine's own folders do not get into an image: it is the same wherever it is built, and shorter.
fn remap(from: &Path, to: &str) -> String {
    format!("'--remap-path-prefix={}={to}'", from.display())
}

/// The project's root folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask lies in the project's root")
        .to_path_buf()
}

/// Where everything for the target is built: its own folder, since the compiler may be another one.
pub fn target_dir() -> PathBuf {
    root().join("target").join("arm")
}

/// Finds or sets up a toolchain for [`TARGET`].
///
/// `COURIER_ARM=rustup` or `COURIER_ARM=debian` tries only that way.
///
/// # Errors
/// Neither way can be had: the message says what to install by hand.
pub fn ensure() -> Result<Arm> {
    match env::var("COURIER_ARM").as_deref() {
        Ok("rustup") => rustup(),
        Ok("debian") => debian(),
        Ok(other) => bail!("COURIER_ARM: found {other:?}, wanted `rustup` or `debian`"),
        Err(_) => rustup().or_else(|why| {
            if !why.is::<permission::NotSetUp>() {
                say(&format!("{why:#}; trying Debian's compiler"));
            }
            debian()
        }),
    }
}

/// What [`ensure()`] would run to get what is missing; nothing if there is a compiler.
pub fn missing() -> Vec<String> {
    let debian = || format!("apt-get install {}", DEBIAN_COMPILER.join(" "));
    let way = env::var("COURIER_ARM");
    let (rustup, apt) = match way.as_deref() {
        Ok("rustup") => (true, false),
        Ok("debian") => (false, true),
        _ => (true, true),
    };
    let has_rustup = rustup && core_of_rustup().is_ok_and(|core| core.is_dir());
    if has_rustup || apt && debian_is_complete() {
        return Vec::new();
    }
    match (rustup && on_path("rustup"), apt) {
        (true, true) => vec![format!(
            "rustup target add {TARGET}, or where that fails: {}",
            debian()
        )],
        (true, false) => vec![format!("rustup target add {TARGET}")],
        (false, _) => vec![debian()],
    }
}

/// Where rustup keeps the target's `core`.
fn core_of_rustup() -> Result<PathBuf> {
    Ok(sysroot()?.join("lib/rustlib").join(TARGET).join("lib"))
}

fn rustup() -> Result<Arm> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arm = Arm {
        cargo: cargo.into(),
        environment: vec![],
        build_core: false,
    };
    if core_of_rustup()?.is_dir() {
        return Ok(arm);
    }
    permission::wanted(&format!("compiler for {TARGET}"))?;
    say(&format!(
        "target {TARGET} is missing: rustup target add {TARGET}"
    ));
    let added = Command::new("rustup")
        .args(["target", "add", TARGET])
        .stdout(Stdio::null())
        .status()
        .context("rustup")?;
    ensure!(
        added.success() && core_of_rustup()?.is_dir(),
        "rustup cannot add {TARGET} here"
    );
    Ok(arm)
}

fn debian() -> Result<Arm> {
    let (cargo, rustc) = (Path::new(DEBIAN_CARGO), Path::new(DEBIAN_RUSTC));
    if !debian_is_complete() {
        permission::wanted(&format!("compiler for {TARGET}"))?;
        install(&DEBIAN_COMPILER)?;
        ensure!(
            debian_is_complete(),
            "Debian's {} are installed, yet cargo, rustc or the source of core is missing",
            DEBIAN_COMPILER.join(", ")
        );
    }
    let mut path = OsString::from("/usr/bin:");
    if let Some(folder) = rust_lld() {
        path.push(folder);
        path.push(":");
    }
    path.push(env::var_os("PATH").unwrap_or_default());
    let environment = vec![
        ("PATH", path),
        ("RUSTC", rustc.into()),
        ("RUSTC_BOOTSTRAP", "1".into()),
    ];
    Ok(Arm {
        cargo: cargo.into(),
        environment,
        build_core: true,
    })
}

/// Whether Debian's compiler and its source of `core` are there.
fn debian_is_complete() -> bool {
    let source = Path::new("/usr/lib/rustlib/src/rust/library/core/src/lib.rs");
    let rustc = Path::new(DEBIAN_RUSTC);
    Path::new(DEBIAN_CARGO).exists()
        && rustc.exists()
        && (source.exists() || debian_source(rustc).is_some())
}

/// The source of `core` that belongs to this compiler, wherever its sysroot is.
fn debian_source(rustc: &Path) -> Option<PathBuf> {
    let sysroot = output(
        Command::new(rustc)
            .args(["--print", "sysroot"])
            .env_remove("RUSTUP_TOOLCHAIN"),
    )
    .ok()?;
    let source = Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library/core/src/lib.rs");
    source.exists().then_some(source)
}

/// The folder of `rust-lld` in the running toolchain, for a compiler that comes without a linker of its own.
fn rust_lld() -> Option<PathBuf> {
    let hosts = sysroot().ok()?.join("lib/rustlib").read_dir().ok()?;
    hosts
        .flatten()
        .map(|host| host.path().join("bin"))
        .find(|bin| bin.join("rust-lld").exists())
}

/// The running toolchain's folder.
pub fn sysroot() -> Result<PathBuf> {
    Ok(output(Command::new("rustc").args(["--print", "sysroot"]))?
        .trim()
        .into())
}

/// Makes sure that `program` can be run; installs Debian's `packages` where it cannot.
///
/// # Errors
/// It is missing and cannot be installed.
pub fn ensure_program(program: &str, packages: &[&str]) -> Result<()> {
    if on_path(program) {
        return Ok(());
    }
    permission::wanted(program)?;
    say(&format!("{program} is missing"));
    install(packages)?;
    ensure!(
        on_path(program),
        "Debian's {} are installed, yet {program} is not on the PATH",
        packages.join(", ")
    );
    Ok(())
}

/// Whether `program` lies in a folder of the PATH.
pub fn on_path(program: &str) -> bool {
    env::split_paths(&env::var_os("PATH").unwrap_or_default())
        .any(|folder| folder.join(program).is_file())
}

/// Installs Debian packages.
///
/// # Errors
/// There is no apt-get, this is not root, or a package cannot be had.
pub fn install(packages: &[&str]) -> Result<()> {
    permission::wanted(&packages.join(", "))?;
    let by_hand = format!("apt-get install {}", packages.join(" "));
    ensure!(
        on_path("apt-get"),
        "no apt-get here; install by hand what Debian calls {}",
        packages.join(" ")
    );
    let root = output(Command::new("id").arg("-u"))?.trim() == "0";
    ensure!(
        root,
        "not root, so nothing was installed; run as root: {by_hand}"
    );
    say(&by_hand);
    let apt = |arguments: &[&str]| -> Result<bool> {
        let mut command = Command::new("apt-get");
        command
            .args(["-qq", "-o", "Dpkg::Use-Pty=0"])
            .args(arguments)
            .env("DEBIAN_FRONTEND", "noninteractive");
        Ok(command
            .stdout(Stdio::null())
            .status()
            .context("apt-get")?
            .success())
    };
    let wanted: Vec<&str> = ["install", "-y", "--no-install-recommends"]
        .iter()
        .chain(packages)
        .copied()
        .collect();
    if !apt(&wanted)? {
        say("apt-get update, then again");
        ensure!(apt(&["update"])? && apt(&wanted)?, "failed: {by_hand}");
    }
    Ok(())
}

/// Runs a command and returns its standard output.
///
/// # Errors
/// It cannot be started, or does not end with success: the message has its standard error.
pub fn output(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let done = command.output().with_context(|| name.clone())?;
    ensure!(
        done.status.success(),
        "{name}: {}: {}",
        done.status,
        String::from_utf8_lossy(&done.stderr).trim()
    );
    Ok(String::from_utf8_lossy(&done.stdout).into_owned())
}

/// Runs a command, its output going where ours goes.
///
/// # Errors
/// It cannot be started, or does not end with success.
pub fn run(command: &mut Command) -> Result<()> {
    let name = format!(
        "{} {}",
        command.get_program().to_string_lossy(),
        command
            .get_args()
            .next()
            .unwrap_or_default()
            .to_string_lossy()
    );
    let status = command.status().with_context(|| name.clone())?;
    ensure!(status.success(), "{name}: {status}");
    Ok(())
}

/// One line on standard error about what is being set up.
pub fn say(step: &str) {
    eprintln!("arm: {step}");
}
