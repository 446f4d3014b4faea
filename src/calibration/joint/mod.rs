//! Joint calibration of the platen sensor and the coordination sensor under a beacon: equations (5), (9), (10), (11).
//!
//! `sample` (buffer of poses) -> `constraint` (three whitened rows a pose) -> `solver` (Gauss-Newton) -> `steps` (schedule, held-out
//! acceptance). `layout` orders the unknowns and removes the gauge freedoms; `sensor` has the diode's own errors.

mod constraint;
mod layout;
mod sample;
pub mod sensor;
mod solver;
mod steps;
mod whitening;

pub use constraint::{Constraints, Misclosure, ReadingNoise, Rows, Values, Weighting};
pub use layout::{Groups, JOINT_UNKNOWNS, Layout, MAX_FITTED, Unknown};
pub use sample::{JointBuffer, JointSample, POSES};
pub use solver::{FitReport, JointEstimator, JointSolver, Priors};
pub use steps::{HeldOut, JointProgress, Step, StepReport, make_step};
