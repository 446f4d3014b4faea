//! Simulated courier: f64 plant, embedded-hal parts that answer on the wire, faults.
//!
//! spec -> courier (pose to counts) <- trajectory (motion); presets build specs, record makes whole recordings.

pub mod ageing;
pub mod banks;
pub mod beacon_fault;
pub mod board;
pub mod coordination;
pub mod courier;
pub mod electronics;
pub mod presets;
pub mod record;
mod shared_flash;
pub mod spec;
pub mod trajectory;
pub mod waveform;
pub mod wire;
pub mod wire_fault;
pub mod world;
