//! What every board runs: the sampling interrupt's half, the intake of frames, and the background's half.
//!
//! `sampler` is the interrupt; `intake`, an interrupt below it, takes every frame; `frames` are the queues between them. `background` runs
//! everything else: `guide` moves the courier,
//! `keeper` holds what is in force and stored, `homing` finds the teeth of a stored tooth map, `updates` takes a new firmware in, `console` speaks the debug link (`ordered`: what it says
//! of calibrations), `restarts`
//! counts faults in a row, `events` tells what is new for the log, `watcher` watches the calibration in force.

pub mod background;
pub mod console;
pub mod events;
pub mod frames;
pub mod guide;
pub mod homing;
pub mod intake;
pub mod keeper;
mod ordered;
pub mod restarts;
pub mod sampler;
pub mod task;
pub mod updates;
pub mod watcher;
