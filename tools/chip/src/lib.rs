//! A model of the STM32G474 that runs the firmware's image as it ships, byte for byte, and fails where the chip's manuals are not kept.
//!
//! `rule` lists what a run must keep; `registers` are the chip's own tables; `peripheral` holds one peripheral a file, `chip` joins them,
//! `lines` are the board's wires to `surroundings`, which are `hal-sim`'s parts; `processor` runs the instructions (unicorn) with exceptions,
//! time and protection around them; `image` is the file; `wire` the debug link; `check` what `cargo xtask chip` runs.

pub mod check;
pub mod chip;
pub mod image;
mod lines;
pub mod peripheral;
pub mod processor;
pub mod registers;
pub mod rule;
pub mod surroundings;
pub mod time;
pub mod wire;
