//! Which board a command talks to: `choice` are the options by which a user names one (`ageing`: what changes of a simulated
//! one), `emulated` builds and starts the emulated
//! one, `chip` starts the model of the chip, `claim` keeps two commands from one board, `geometry` asks
//! what a board reckons with. What is asked of a board, whichever it is, is in the package `board-link`.

mod ageing;
pub mod chip;
mod choice;
pub mod claim;
pub mod emulated;
pub mod geometry;

pub use board_link::image::{DEVELOPMENT_SEED, Image};
pub use board_link::{Link, SimWire, Simulated, Starter, map, motion, session, update};
pub use choice::{Choice, Kind, Opened, target};
