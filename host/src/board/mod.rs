//! A board at the other end of the debug link, whichever it is: simulated in this process, emulated, or on a probe.
//!
//! `link` asks and listens, `sim` is the simulated board, `emulated` the emulated one, `choice` the options by which a user names one.

mod choice;
pub mod emulated;
mod link;
mod sim;

pub use choice::{Choice, Opened};
pub use link::Link;
pub use sim::SimWire;
