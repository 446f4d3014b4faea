//! Firmware update into the flash bank that no code runs from. `docs/update.md` tells the whole way.
//!
//! ```text
//! host: header, body -> install (erase, program, check) -> journal: number -> restart
//! first stage: standing of both banks -> choice -> journal: one trial -> start
//! new image: mirror (the calibration) -> works, host agrees -> journal: accepted
//! ```
//! Everything here is written against embedded-storage's traits: the same code runs on the board, in its first stage, on the simulated
//! board and in tests that cut the power at every step.

pub mod choice;
pub mod header;
pub mod install;
pub mod journal;
pub mod key;
pub mod layout;
pub mod mirror;
pub mod order;
pub mod standing;
pub mod trial;
pub mod version;
