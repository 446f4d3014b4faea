//! The model on disk, where it knows what it speaks of, and its check on another recording.

pub mod amplitude_support;
mod applied;
mod arbitrary;
mod aside;
pub mod check;
pub mod model;
pub mod support;
