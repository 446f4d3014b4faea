//! Recordings as they come from the field, through the command: too short, dead, clipped, wrongly stated, with other rates and
//! other columns. Each must be answered with the limit that it violates, or at least with no wrong name; never with a panic.
//!
//! The couriers are those of the independent simulator ([`specimens::rig`]), with nothing wrong or with one effect.

mod field;

mod answered;
mod limits;
mod noise;
mod reference;
mod schema;
