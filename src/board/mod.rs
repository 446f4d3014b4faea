//! What only the target has. The one place of `unsafe` in the firmware.

pub mod fpu;
