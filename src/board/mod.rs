//! What only the target has. The one place of `unsafe` in the firmware.
//!
//! `emulated` and `g474` are the boards; `main_loop` runs on both, over the trait [`main_loop::Board`]. `first_stage` is a program of its own
//! that runs before the `g474` firmware and chooses its bank.

#[cfg(feature = "board")]
mod critical;
#[cfg(feature = "emulated")]
pub mod emulated;
#[cfg(feature = "board")]
pub mod fault;
#[cfg(feature = "first-stage")]
pub mod first_stage;
#[cfg(any(feature = "g474", feature = "first-stage"))]
mod flash_controller;
#[cfg(feature = "g474")]
pub mod g474;
#[cfg(feature = "board")]
mod guard;
#[cfg(feature = "board")]
mod hang;
#[cfg(feature = "board")]
mod intake;
#[cfg(feature = "board")]
pub mod interrupt;
#[cfg(feature = "board")]
pub mod main_loop;
#[cfg(feature = "board")]
mod memory;
#[cfg(feature = "board")]
mod once;
pub(crate) mod room;
#[cfg(feature = "board")]
pub mod rtt;
#[cfg(feature = "board")]
mod start;
#[cfg(any(feature = "g474", feature = "first-stage"))]
mod watchdog;

/// What a board does at each look for a hang.
#[cfg(feature = "g474")]
use g474::at_look;
/// Nothing: this board has one watchdog.
#[cfg(feature = "emulated")]
fn at_look() {}

/// RAM's first byte; the stack ends there, since nothing may lie below it (flip-link).
#[cfg(feature = "g474")]
const RAM_START: u32 = 0x2000_0000;
#[cfg(feature = "emulated")]
const RAM_START: u32 = crate::emulation::RAM_BASE;
