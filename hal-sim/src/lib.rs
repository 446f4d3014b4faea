//! Simulated courier: f64 plant, embedded-hal parts that answer on the wire, faults.

pub mod wire;
