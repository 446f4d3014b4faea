//! The peer of the cost table: CMSIS-DSP (Apache-2.0) from its public Python source package, built here, never committed.

use crate::arm::{ensure_program, output, root, run, say};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Version that the figures are for.
const VERSION: &str = "1.10.3";
/// What the peer calls, and what that calls.
const SOURCES: [&str; 6] = [
    "FastMathFunctions/arm_sin_f32",
    "FastMathFunctions/arm_cos_f32",
    "FastMathFunctions/arm_atan2_f32",
    "BasicMathFunctions/arm_dot_prod_f32",
    "CommonTables/arm_common_tables",
    "CommonTables/arm_const_structs",
];
/// The fastest that the library is built with.
const FLAGS: [&str; 8] = [
    "-mcpu=cortex-m4",
    "-mthumb",
    "-mfloat-abi=hard",
    "-mfpu=fpv4-sp-d16",
    "-Ofast",
    "-ffunction-sections",
    "-fdata-sections",
    "-c",
];

/// Folder with `libpeer.a`.
///
/// # Errors
/// No compiler, or the package cannot be had.
pub fn build() -> Result<PathBuf> {
    let folder = root().join("target").join("cmsis");
    let archive = folder.join("libpeer.a");
    let source = root().join("bench/peers/cmsis.c");
    if newer(&archive, &source) {
        return Ok(folder);
    }
    ensure_program(
        "arm-none-eabi-gcc",
        &["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"],
    )?;
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let library = download(&folder)?;
    say("building CMSIS-DSP with arm-none-eabi-gcc -Ofast");
    let mut objects = vec![compile(&folder, &library, &source)?];
    for name in SOURCES {
        objects.push(compile(
            &folder,
            &library,
            &library.join("Source").join(name).with_extension("c"),
        )?);
    }
    let _ = fs::remove_file(&archive);
    run(Command::new("arm-none-eabi-ar")
        .arg("rcs")
        .arg(&archive)
        .args(&objects))?;
    Ok(folder)
}

fn newer(product: &Path, source: &Path) -> bool {
    let time = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
    matches!((time(product), time(source)), (Some(p), Some(s)) if p > s)
}

/// The unpacked source package.
fn download(folder: &Path) -> Result<PathBuf> {
    let name = format!("cmsisdsp-{VERSION}");
    let unpacked = folder.join(&name);
    if !unpacked.is_dir() {
        say(&format!("pip download cmsisdsp=={VERSION}"));
        let package = format!("cmsisdsp=={VERSION}");
        output(Command::new("pip").current_dir(folder).args([
            "download",
            "--quiet",
            "--no-deps",
            "--no-binary",
            "cmsisdsp",
            &package,
        ]))?;
        output(
            Command::new("tar")
                .current_dir(folder)
                .args(["xzf", &format!("{name}.tar.gz")]),
        )?;
    }
    Ok(unpacked)
}

fn compile(folder: &Path, library: &Path, source: &Path) -> Result<PathBuf> {
    let object = folder
        .join(source.file_stem().unwrap_or_default())
        .with_extension("o");
    let include = |path: PathBuf| format!("-I{}", path.display());
    run(Command::new("arm-none-eabi-gcc")
        .args(FLAGS)
        .arg(include(root().join("bench/peers/include")))
        .arg(include(library.join("Include")))
        .arg(include(library.join("PrivateInclude")))
        .arg(source)
        .arg("-o")
        .arg(&object))?;
    Ok(object)
}
