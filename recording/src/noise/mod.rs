//! Noise that a recording states, measured from readings.
//!
//! Two situations, two estimators. A courier that is told to rest shows its noise beside a parabola: [`at_rest`], which refuses readings
//! that move. A log of which nothing is known holds motion almost everywhere: [`in_motion`] takes its slowest part, and says where that
//! holds motion still.

pub mod at_rest;
pub mod in_motion;

/// Variance that rounding to whole steps adds, in squared steps: that of an even distribution over one step.
pub const ROUNDING_VARIANCE: f64 = 1.0 / 12.0;
