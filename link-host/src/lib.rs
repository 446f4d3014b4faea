//! The host's way to a board: [`rtt`] speaks SEGGER's real-time transfer over any [`memory::TargetMemory`], be it a debug
//! probe's or the emulated board's; [`chip`] runs the image as it ships on a model of its chip, a program of its own. All are wires of
//! the package `board-link`, which is what the commands use.

#[cfg(target_os = "linux")]
mod child;
pub mod chip;
pub mod emulated;
pub mod image;
pub mod memory;
pub mod option_bytes;
pub mod outdated;
#[cfg(feature = "probe")]
pub mod probe;
pub mod rtt;
