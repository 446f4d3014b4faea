//! Calibration on the device: the session, its acceptance, and what is stored of it. Root of the package `courier-calibration`, which the
//! firmware's library re-exports.
//!
//! A package of its own because the images build it as small as it gets (`Cargo.toml`, profile `firmware`): it runs in the main loop alone.
//! Knows nothing of drivers, links or boards.
//!
//! Of a session: `session` (state machine) -> `average` (one pose's frames) -> `gate` (outliers, rows) -> `regression` (equation 7)
//! -> `outcome`. `plan` chooses the poses, `visits` says how many and how long. `record` and `slots`: what is stored, and where.
//! `watch`, `rest_watch`: whether it stays true.
#![no_std]

mod average;
mod config;
pub mod device;
mod gate;
pub mod joint;
pub mod motion;
mod outcome;
mod plan;
mod port;
mod quotient;
pub mod recalibration;
pub mod record;
mod regression;
pub mod rest_watch;
mod sample;
mod service;
mod session;
pub mod sink;
pub mod slots;
mod spread;
mod start_error;
mod visit;
mod visits;
pub mod watch;

pub use average::{FRAMES as AVERAGED_FRAMES, UNUSABLE};
pub use config::SessionConfig;
pub use gate::{GatedFit, PlatenEstimator, STARTUP, Verdict};
pub use outcome::{AcceptanceLimits, Evidence, Length, Outcome, Refusal};
pub use plan::{Plan, Planner, Range, RelativePose, foreseen};
pub use port::{Action, MotionEvent, Progress, Stage};
pub use quotient::quotient;
pub use regression::{PLATEN_UNKNOWNS, Regression};
pub use sample::Sample;
pub use service::Service;
pub use session::{LEAST_POSES, Session};
pub use start_error::StartError;
pub use visits::Visits;

use courier_signal::{diode, equations, frame, geometry, lsq, math, model, quadrature, range};
