//! What a recalibration starts from, and what it may do.

use crate::watch::WatchConfig;
use serde::{Deserialize, Serialize};

/// What becomes of a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// None is looked for.
    Off,
    /// It is shown, and comes in force when a host says so.
    #[default]
    Propose,
    /// It is stored and comes in force by itself.
    Automatic,
}

/// What a recalibration starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecalibrationConfig {
    /// Prior deviation of what the calibration left of one amount, metres.
    pub left_m: f32,
    /// The same of what it left in the parity, which a window's columns may take for an amount. A reference tells it.
    pub shape_m: f32,
    /// What it left in the parity, metres rms.
    pub residual_m: f32,
    /// Prior deviation of what has changed of it since, metres.
    pub changed_m: f32,
    /// Slopes of its corrections over the output, as the watch has them.
    pub slopes: [f32; 3],
    /// By how much it was amended before, metres rms.
    pub amended_m: f32,
}

/// Of what is left in the parity, what one amount may take for its own in one motion and not in another: what is left is some six
/// waves, as the watch has it, and their phases stand to the own phases otherwise by a quarter of a radian where the courier is
/// turned by half a degree (span and lateral arm 9.7 mm together, pitch 1.016 mm): 0.25 sqrt(2 / 6). A derivation: the share of
/// one wave of six, times that turn.
pub(super) const APART: f32 = 0.14;

impl RecalibrationConfig {
    /// Of no calibration.
    pub(super) const NONE: Self = Self {
        left_m: 0.0,
        shape_m: 0.0,
        residual_m: 0.0,
        changed_m: 0.0,
        slopes: [0.0; 3],
        amended_m: 0.0,
    };

    /// Of a stored calibration, as the watch takes it. Its record keeps no covariance: poses are planned so that it is all but diagonal (condition number 8,
    /// paper 3.1.2), and its size follows from the worst predicted deviation of a correction. That is the sum of four waves of two amounts
    /// each, so that no amount's deviation is larger. What may have changed since is as much as the watch tells of one wave.
    /// `amended_m`: by how much it was amended before, rms.
    #[must_use]
    pub fn of(config: &WatchConfig, amended_m: f32) -> Self {
        Self {
            left_m: config.uncertainty_m,
            shape_m: config.shape_m(),
            residual_m: config.residual_m,
            changed_m: config.told_m(),
            slopes: config.slopes,
            amended_m,
        }
    }
}
