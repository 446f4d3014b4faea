//! Memory map and linker scripts of the images. Does nothing for a build without a board.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    let feature = |name: &str| env::var_os(format!("CARGO_FEATURE_{name}")).is_some();
    println!("cargo:rerun-if-changed=build.rs");
    if !feature("BOARD") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let map = if feature("G474") {
        "memory.x"
    } else {
        "memory-emulated.x"
    };
    println!("cargo:rerun-if-changed={map}");
    fs::copy(Path::new(map), out.join("memory.x")).expect("the memory map is beside build.rs");
    if !feature("G474") {
        // The machine's vectors are in the board's own file.
        fs::write(out.join("device.x"), "").expect("OUT_DIR can be written");
    }
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
}
