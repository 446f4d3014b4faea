//! What the stated noise alone leaves.

pub mod simulated;
