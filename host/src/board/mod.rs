//! A board at the other end of the debug link, whichever it is: simulated in this process, emulated, or on a probe.
//!
//! `link` asks and listens, `map` loads, `motion` moves the courier, `session` waits for a calibration, `sim` is the simulated board,
//! `emulated` the emulated one, `simulated` either of them with the courier around it, `choice` the options by which a user
//! names one.

mod choice;
pub mod emulated;
mod link;
pub mod map;
pub mod motion;
pub mod session;
mod sim;
mod simulated;

pub use choice::{Choice, Kind, Opened};
pub use link::Link;
pub use sim::SimWire;
pub use simulated::{On, Simulated};
