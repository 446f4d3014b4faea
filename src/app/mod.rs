//! The two halves of the firmware that every board runs: the interrupt's and the background's.
//!
//! `sampler` is the interrupt, `frames` the queue from there; `background` runs everything below it: `guide` moves the courier,
//! `keeper` holds what is in force and stored, `updates` takes a new firmware in, `console` speaks the debug link (`ordered`: what it says
//! of calibrations), `restarts`
//! counts faults in a row.

pub mod background;
pub mod console;
pub mod frames;
pub mod guide;
pub mod keeper;
mod ordered;
pub mod restarts;
pub mod sampler;
pub mod task;
pub mod updates;
