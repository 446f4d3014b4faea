//! Joint calibration of the platen sensor and the coordination sensor under a beacon: equations (5), (9), (10), (11).
//!
//! `sample` (buffer of poses) -> `constraint` (three whitened rows a pose) -> `fit` (Gauss-Newton with `solver`) -> `steps`
//! (schedule, held-out acceptance). `layout` orders the unknowns and removes the gauge freedoms; the diode's own errors are in [`crate::diode`].

mod config;
mod constraint;
mod fit;
mod layout;
mod median;
mod outcome;
mod plan;
mod sample;
mod session;
mod solver;
mod steps;
mod whitening;

pub use config::{JointConfig, JointLimits, entered, model_of};
pub use constraint::{Constraints, Misclosure, ReadingNoise, Rows, Weighting};
pub use courier_signal::diode as sensor;
pub use layout::{Groups, JOINT_UNKNOWNS, Layout, MAX_FITTED, Unknown, Values};
pub use outcome::{JointOutcome, JointResult};
pub use plan::{about_sensor, foreseen_under_beacon};
pub use sample::{FARTHEST_TEETH, JointBuffer, JointSample, POSES, Poses};
pub use session::JointSession;
pub use solver::{FitReport, JointEstimator, JointRows, JointSolver, Priors};
pub use steps::{HeldOut, JointProgress, Step, StepReport, Trial};
