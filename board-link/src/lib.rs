//! A board at the other end of its debug link, whichever it is: [`Wire`] carries bytes to it and from it.
//!
//! [`Link`] asks and listens, [`map`] loads, [`motion`] moves the courier, [`session`] waits for a calibration, [`update`] brings a new
//! firmware, whose file is an [`image`]. [`SimWire`] is a board
//! simulated in this process; [`Simulated`] is a board with a simulated courier around it. Emulated boards and boards behind a
//! debug probe are wires of the package `link-host`.

pub mod image;
mod link;
pub mod map;
pub mod motion;
pub mod session;
mod sim;
mod simulated;
pub mod update;
mod wire;

pub use link::Link;
pub use sim::SimWire;
pub use simulated::{Simulated, Starter};
pub use wire::Wire;
