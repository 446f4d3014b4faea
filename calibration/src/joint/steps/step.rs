//! The steps of the schedule, in order.

use crate::joint::layout::Groups;
use serde::{Deserialize, Serialize};

/// Misclosures longer than this many times their rms say nothing about a step, nor about the noise. Derived from the normal tail:
/// none in 10^14, so that only what is no noise is beyond.
pub(super) const OUTLIER: f32 = 8.0;

/// A step of the schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Step {
    /// Own-phase coefficients, by g_p.
    Platen,
    /// Height, lever arm and beacon's place, platen fixed.
    Mounting,
    /// Everything of the paper's 3.2 together.
    Joint,
    /// That and the diode's angle and difference of gains.
    Misalignment,
    /// That and the diode's terms of second and third degree.
    Nonlinearity,
}

impl Step {
    /// In order.
    pub const ALL: [Self; 5] = [
        Self::Platen,
        Self::Mounting,
        Self::Joint,
        Self::Misalignment,
        Self::Nonlinearity,
    ];
    /// The paper's three.
    pub const PAPER: [Self; 3] = [Self::Platen, Self::Mounting, Self::Joint];

    /// What it frees, given what the steps before have freed for good.
    pub(super) fn groups(self, accepted: Groups) -> Groups {
        match self {
            Self::Platen => Groups::PLATEN,
            Self::Mounting => Groups::MOUNTING,
            Self::Joint => Groups::PAPER,
            Self::Misalignment => Groups::PAPER | Groups::MISALIGNMENT,
            Self::Nonlinearity => {
                Groups::PAPER | (accepted & Groups::MISALIGNMENT) | Groups::NONLINEARITY
            }
        }
    }
}
