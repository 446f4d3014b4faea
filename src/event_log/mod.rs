//! The board's own story, kept in flash: starts and their causes, faults, calibrations, tooth maps, the watch's findings, updates.
//!
//! [`entry`] says what is kept, [`store`] how it lies in flash, [`page`] how it goes to a host, [`pace`] how often something may be written. `crate::app::events` finds out
//! what is new.

pub mod entry;
pub mod pace;
pub mod page;
pub mod store;
