//! The whole of the main job on a simulated courier: boot, self-motions, calibration, storage, restart, fly-by.
//!
//! `run` goes through it with the firmware's own code, `flyby` judges a flight against the interferometer, `report` holds
//! the paper's table beside the figures found, `record` keeps what was measured. `joint` is the paper's second half.

mod flyby;
pub mod joint;
mod record;
mod report;
mod run;

pub use report::{Report, ReportRow};
pub use run::{Options, Plan, Preset, run};
