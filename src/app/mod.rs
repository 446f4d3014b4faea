//! The two halves of the firmware that every board runs: the interrupt's and the background's.

pub mod sampler;
