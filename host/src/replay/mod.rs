//! The firmware's signal path and estimator on a recording: what remains on stretches that were not fitted.
//!
//! `channel` says what is fitted to what, `blocks` which samples are held out, `fit` solves incrementally in f32 and
//! at once in f64, `report` puts the figures together.

mod blocks;

pub use blocks::{Split, split};
