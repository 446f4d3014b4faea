//! The watch over a calibration in service: false alarms, changes that are told, and what motion does not show.

mod bench;
mod board;
mod changes;
mod kept;
mod service;
mod traffic;
