//! Couriers drawn from a seed, with effects that are known, on which the diagnosis is checked.
//!
//! [`drawn`] draws from the project's own catalogue and simulator. [`rig`] is a second simulator that shares no code with either.
//! [`conditions`] draws motions,
//! temperature and what is recorded anew for each courier. None of them knows the diagnosis.

pub mod conditions;
pub mod drawn;
pub mod rig;

pub use conditions::Conditions;
pub use drawn::{Case, Drawn, Kind, SIZES_M};
