//! A calibration that is kept true by ordinary motion: what has changed since it was made is estimated from the watch's windows.
//!
//! Each complete window of [`super::watch`] is, once its offset and its products of both phases are taken out, a regression of what has
//! changed of equation (3)'s amounts since the reference ([`Whole`](super::watch::Whole)). Its rows enter a second estimator that forgets
//! ([`Learner`]). Before they do, they test what the estimator made of the windows before: rows that neither the calibration in force nor
//! its candidate has seen. A candidate is proposed when two things hold:
//!
//! * *It fits better.* `d` is by how much the candidate lowers half the sum of squares of a window, and `v` the variance of `d`. The sum of
//!   `d/2 - v/8`, cut off at zero, passes `h` by chance in one window of `e^h` at most, whatever the candidate is and however the motion
//!   chose it, where the candidate is no better than the calibration in force: the exponential of `d/2 - v/8` is then expected to be one at
//!   most (Ville 1939; Lorden 1971; Ramdas et al. 2023, Statistical Science 38, 576).
//! * *The position gains.* By the covariance of the estimate the mean square of the position's error along an axis becomes smaller on
//!   any motion, be it one that turns as little as calibrations do or any angle: by five deviations, of what is drawn once by 3.4
//!   (`belief.rs`). In that covariance is what the motion does not determine, what the reference did not know, what windows differ by
//!   beyond their noise, and what equation (3) does not hold. Of each order as much is taken as is expected to be nearest to the truth,
//!   and of all orders along the axis the part that surely gains.
//!
//! What ordinary motion does not determine stays as it was, by a prior ([`RecalibrationConfig::of`]). The constants k_i,0 stay: they wander
//! with the temperature, and the parity does not tell which segment's it is.
//!
//! Pure: no clock, no allocation, no panic.

mod belief;
mod candidate;
mod config;
mod gain;
mod learner;
mod told;

pub use candidate::{Proposal, amend};
pub use config::{Mode, RecalibrationConfig};
pub use learner::Learner;
pub use told::{Idle, Order, Recalibration, State};
