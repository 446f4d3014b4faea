//! Memory map and linker scripts.

use std::path::PathBuf;

fn main() {
    let here = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    // The machine's vectors are in the board's own file.
    std::fs::write(out.join("device.x"), "").expect("OUT_DIR can be written");
    std::fs::copy(here.join("memory.x"), out.join("memory.x")).expect("it is beside this file");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    // Functions of the same instructions are one.
    println!("cargo:rustc-link-arg-bins=--icf=all");
}
