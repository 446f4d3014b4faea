//! Linker scripts of the sensor board's image; its memory map is `memory.x` beside this file. Nothing for other builds.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    if std::env::var_os("CARGO_FEATURE_G474").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        if std::env::var_os("CARGO_FEATURE_BEHIND_FIRST_STAGE").is_some() {
            // BODY_START of src/update/layout.rs.
            println!("cargo:rustc-link-arg-bins=--defsym=_image_offset=0x1200");
            // Or the linker puts the file's own header where the first stage is.
            println!("cargo:rustc-link-arg-bins=--nmagic");
        }
        // Functions of the same instructions are one.
        println!("cargo:rustc-link-arg-bins=--icf=all");
    }
}
