//! The watch over a calibration in service: false alarms, changes that are told, and what motion does not show.

pub mod bench;
pub mod board;
mod changes;
mod kalman;
mod kept;
pub mod service;
pub mod traffic;
