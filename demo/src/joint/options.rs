//! What the demonstration of the joint calibration is to do.

use crate::Preset;
use board_link::Starter;

/// What to demonstrate.
#[derive(Clone, Debug, Default)]
pub struct JointOptions {
    /// What the firmware runs on.
    pub board: Starter,
    /// Which courier.
    pub preset: Preset,
    /// Seed of the courier, its noise, its poses and the synthetic problems.
    pub seed: u64,
    /// Poses to fit in each session; none: 1000.
    pub poses: Option<u32>,
    /// Draws another platen under the paper's courier; none: its own.
    pub platen: Option<u64>,
}
