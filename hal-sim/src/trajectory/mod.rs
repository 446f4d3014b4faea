//! Motions of the open-loop courier: moves, their errors, their settling, and the usual runs of a recording.

mod open_loop;
mod profile;
mod runs;
mod schedule;

pub use open_loop::{OpenLoop, PlaceError};
pub use profile::Profile;
pub use runs::{
    BEACON_ANGLE_RAD, BEACON_SPEED_M_S, BEACON_SWEEP_M, FLYBY_M, FLYBY_SPEED_M_S, Plan, Run,
    SCATTER_ANGLE_RAD, SLOW_SPEED_M_S, SPIN_ANGLE_RAD,
};
pub use schedule::{Path, Schedule};
