//! Couriers drawn from a seed, with effects that are known, on which the diagnosis is checked.
//!
//! [`drawn`] draws from the project's own catalogue and simulator. [`rig`] is a second simulator that shares no code with either.
//! Neither knows the diagnosis.

pub mod drawn;
pub mod rig;

pub use drawn::{Case, Drawn, Kind, SIZES_M};
