//! The simulated courier, and the firmware on it.
//!
//! One program of many files: each further program would be linked, and its helpers compiled, once more.

mod beacon_watch;
mod bench;
mod board_faults;
mod events;
mod figures;
mod health;
mod joint_refusals;
mod maps;
mod parity_watch;
mod plant;
mod recalibration;
mod rests;
mod session;
mod watch;
