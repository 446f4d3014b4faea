//! What only the model of the chip is asked: the commands as built on the image as it ships (`courier --chip …`), and what a logic analyser
//! sees at its pins. `cargo xtask chip --tests` runs them, and those of the emulated board that this one can take too; `cargo xtask test`
//! runs those that are short.

mod calibration;
mod commands;
#[path = "../suite/common/mod.rs"]
mod common;
mod trace;
