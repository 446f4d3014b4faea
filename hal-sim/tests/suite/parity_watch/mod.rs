//! The watch over the parity at rests: false alarms, and changes that are told with their coordinate.

mod bench;
mod board;
mod changes;
mod hours;
