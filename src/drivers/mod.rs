//! Drivers over embedded-hal and embedded-io traits: the same code on the board, on the emulated one and in the simulator.
//!
//! `converter` is the pair of AD7606C-16 that samples all 12 channels at one instant, `ad7606c` one such chip,
//! `g4_flash` the flash that the STM32G4 has, `motion` the serial line to the courier's motion controller.

pub mod ad7606c;
pub mod converter;
pub mod g4_flash;
pub mod motion;
