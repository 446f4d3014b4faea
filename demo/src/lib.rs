//! The whole of the main job on a simulated courier: boot, self-motions, calibration, storage, restart, fly-by.
//!
//! `options` say what to demonstrate, `preset` on which courier. `run` goes through it over the debug link of a board, simulated or emulated; `flight` flies, `flyby` judges a flight against
//! the interferometer, `report` holds the paper's table beside the figures found, `record` keeps what was measured. `joint` is
//! the paper's second half. `command` are the options of `cargo demo` and `courier demo`, `text` is what they print.

mod command;
mod flight;
mod flyby;
pub mod joint;
mod linked;
mod options;
mod preset;
mod record;
mod report;
mod run;
mod standstill;
mod still;
mod text;

pub use command::{Args, On, demo};
pub use options::{Options, Plan};
pub use preset::Preset;
pub use report::{Report, ReportRow};
pub use run::run;
