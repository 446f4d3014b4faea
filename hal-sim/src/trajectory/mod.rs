//! Motions of the open-loop courier: moves, their errors, their settling, and the usual runs of a recording.

mod open_loop;
mod profile;
mod runs;
mod schedule;

pub use open_loop::{OpenLoop, PlaceError};
pub use profile::Profile;
pub use runs::{Plan, Run};
pub use schedule::{Path, Schedule};
