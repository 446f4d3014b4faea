//! A board at the other end of the debug link, whichever it is: simulated in this process, emulated, or on a probe.
//!
//! `link` asks and listens, `sim` is the simulated board, `choice` the options by which a user names one.

mod choice;
mod link;
mod sim;

pub use choice::{Choice, Opened};
pub use link::Link;
pub use sim::SimWire;
