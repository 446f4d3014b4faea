//! Gives the linker the memory map and, for the peer, CMSIS-DSP as `cargo xtask bench` built it.

fn main() {
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-link-search={here}");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-env-changed=COURIER_CMSIS");
    if std::env::var_os("CARGO_FEATURE_CMSIS").is_some() {
        let folder = std::env::var("COURIER_CMSIS").unwrap_or_default();
        println!("cargo:rustc-link-search={folder}");
        println!("cargo:rustc-link-lib=static=peer");
        println!("cargo:rerun-if-changed={folder}/libpeer.a");
    }
}
