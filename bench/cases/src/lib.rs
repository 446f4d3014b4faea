//! What host and target both compute: inputs from a seed, and digests of every bit of the results.
//!
//! Used by `cargo xtask bench` (costs on the emulated Cortex-M4F) and by the parity check (same digest on both sides).
#![no_std]

pub mod digest;
pub mod encoder;
pub mod inputs;
pub mod joint;
pub mod parity;
pub mod rows;
pub mod setups;

/// Unknowns of the platen calibration: 4 segments of 8 coefficients and the one sum of offsets.
pub const UNKNOWNS: usize = 33;
/// Entries of its packed triangle.
pub const PACKED: usize = courier_sensor::lsq::packed_len(UNKNOWNS);
