//! The firmware without a board: estimator, signal path, drivers, link and flash against simulated parts.
//!
//! One program of many files: each further program would be linked, and its helpers compiled, once more.

mod calibration;
mod calibration_refusals;
mod common;
mod condition;
mod converter;
mod event_log;
mod faults;
mod joint;
mod joint_session;
mod link;
mod lsq;
mod maps;
mod model;
mod motion;
mod signal_faults;
mod slots;
mod step;
mod teeth;
mod update;
