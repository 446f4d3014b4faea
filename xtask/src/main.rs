//! Drives the checks of the project.
fn main() {}
