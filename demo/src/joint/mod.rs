//! The paper's section 3.2.1 with our own figures beside it: `courier demo --joint`.
//!
//! `synthetic` is the paper's synthetic problem. `run` takes a simulated courier through platen calibration, joint calibration
//! under a beacon and the 8 mm fly-by, with the firmware's own code, as `options` say; `session` orders one joint calibration, `poses` keeps what it saw at each pose, `paper_method` fits
//! the paper's equations to the same poses, `report` holds the table, `sensitivity` tells what a pair hides before calibration, `steps` are what the progress bar
//! counts. This
//! system's flight is judged by the platen sensor's pose as the interrupt gives it, with the tooth map of the package `tooth-map` in force.

mod mapping;
mod options;
mod paper_method;
mod poses;
mod report;
mod run;
mod sensitivity;
mod session;
mod steps;
mod synthetic;

pub use options::JointOptions;
pub use report::{JointReport, JointRow, WithoutMap};
pub use run::run;
