//! The signal path and the least squares: root of the package `courier-signal`, which the firmware's library re-exports.
//!
//! A package of its own because the images build it for speed and everything else for size. Knows nothing of drivers, links
//! or boards.
#![no_std]

#[cfg(target_os = "none")]
mod arm;
pub mod beacon;
pub mod diode;
pub mod encoder;
pub mod equations;
pub mod frame;
pub mod geometry;
mod lanes;
pub mod lsq;
pub mod math;
pub mod model;
pub mod psd;
pub mod quadrature;
pub mod queue;
pub mod range;
pub mod settings;
pub mod step;
pub mod swap;
pub mod teeth;
