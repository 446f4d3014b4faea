//! What keeps a motion controller from moving, as far as a calibration tells of it.

use serde::{Deserialize, Serialize};

/// What keeps the controller from moving.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum FaultCode {
    /// A drive's current or temperature is over its limit.
    Overload,
    /// The courier left its area or lifted off.
    Stalled,
    /// Air bearing or supply is off.
    NotReady,
}

/// Why a command was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Refusal {
    /// The pose is outside the platen or its angle too large.
    OutOfReach,
    /// The speed limit is not a positive number.
    BadSpeed,
    /// A fault stands.
    Faulted(FaultCode),
}
