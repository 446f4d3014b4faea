//! The watch over the beacon's part of a calibration: false alarms, and changes that are told with their channel and coordinate.

mod bench;
mod board;
mod changes;
mod hours;
