//! One recording about one point: residuals, their derivatives, the baseline, and fits about what was found.

pub mod baseline;
pub mod calibrate;
pub(crate) mod groups;
pub(crate) mod paths;
pub mod point;
pub mod recording;
pub mod relinearized;
pub mod separation;
pub mod stop_operator;
pub mod unknown_angle;
