//! The firmware's signal path and estimator on a recording: what remains on stretches that were not fitted.
//!
//! `channel` says what is compared with what, `observe` runs the firmware's signal path, `blocks` tells which samples are
//! held out, `fit` solves row by row in f32 (the firmware's estimator) and at once in f64 (its peer), `certainty` tells how well
//! coefficients are known, `report` puts the figures together, `remarks` says what looks wrong about them. `applied` fits nothing: it applies a board's calibration.

mod applied;
mod blocks;
mod certainty;
mod channel;
mod fit;
mod observe;
mod remarks;
mod report;

pub use applied::{Applied, applied};
pub use blocks::{Split, split};
pub use certainty::{Certain, certain};
pub use channel::Channel;
pub use remarks::{Remark, remarks};
pub use report::{ChannelReport, HeldOut, Position, Report, replay};
