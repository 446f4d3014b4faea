//! The point that a recording is linearised about.

use crate::linearization::baseline::Baseline;
use crate::linearization::recording::LatentDisplacement;
use effects::sensor::READINGS;

/// What a recording is linearised about.
#[derive(Clone, Debug, Default)]
pub struct LinearizationPoint {
    /// Parameters of equations (3), (10) and (11).
    pub baseline: Baseline,
    /// What the effects found so far add to the readings.
    pub displacement: LatentDisplacement,
    /// Noise of each reading over the stated one, where it was found to be above.
    pub noise: Option<[f64; READINGS]>,
}
