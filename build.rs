//! Linker scripts of the sensor board's programs: the image, whose memory map is `memory.x` beside this file, and its first stage. Nothing
//! for other builds.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=src/board/first_stage/link.x");
    let argument = |argument: &str| println!("cargo:rustc-link-arg-bins={argument}");
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    if has("G474") {
        argument("-Tlink.x");
        argument("-Tdefmt.x");
    }
    if has("FIRST_STAGE") {
        argument("-Tsrc/board/first_stage/link.x");
    }
    if has("G474") || has("FIRST_STAGE") {
        // Functions of the same instructions are one.
        argument("--icf=all");
        // Or the linker puts the file's own header before the first section.
        argument("--nmagic");
    }
}
