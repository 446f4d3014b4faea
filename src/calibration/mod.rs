//! Self-calibration: from self-motions to coefficients that are accepted, stored and in force.

pub mod record;
pub mod slots;
