//! A model of the STM32G474 that runs the firmware's image as it ships, byte for byte, and fails where the chip's manuals are not kept.
//!
//! `rule` lists what a run must keep; `registers` are the chip's own tables; `peripheral` holds one peripheral a file, `chip` joins them,
//! `lines` are the board's wires to `surroundings`, which are `hal-sim`'s parts, and to what is `beyond` them; `processor` runs the instructions (unicorn) with exceptions,
//! time and protection around them; `image` is the file; `wire` the debug link; `check` what `cargo xtask chip` runs;
//! `recorder` keeps what the lines do, and `trace` writes it as a logic analyser's file;
//! `serve` makes the chip a board of `courier --chip`, whose courier and flash (`bank`) are the `host`'s.

pub mod bank;
pub mod beyond;
pub mod check;
pub mod chip;
pub mod host;
pub mod image;
mod line_levels;
mod lines;
mod memory;
pub mod peripheral;
pub mod processor;
pub mod recorder;
pub mod registers;
pub mod rule;
pub mod serve;
pub mod surroundings;
pub mod time;
pub mod trace;
pub mod wire;
