//! How a joint session ends.

use super::constraint::ReadingNoise;
use super::layout::Groups;
use crate::diode::DiodeErrors;
use crate::geometry::Geometry;
use crate::model::ErrorModel;
use crate::outcome::{Evidence, Refusal};

/// An accepted joint calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct JointResult {
    /// Terms and coefficients. Gauge: pair means of the constants are zero.
    pub model: ErrorModel,
    /// With height and lever arm as found.
    pub geometry: Geometry,
    /// The beacon's place o', metres from the platen sensor's reading at the first pose's whole teeth.
    pub origin_m: [f32; 2],
    /// Those teeth, of x and y.
    pub origin_teeth: [i32; 2],
    /// The coordination sensor's own errors: gain difference, angle, terms of x and y ([`crate::diode::TERMS`]).
    pub sensor: DiodeErrors,
    /// Noise of a pose's readings as the poses show it: what is not modelled is noise.
    pub noise: ReadingNoise,
    /// Groups of unknowns that the data were allowed to set.
    pub groups: Groups,
}

/// How a joint session ended.
#[derive(Clone, Debug, PartialEq)]
pub struct JointOutcome {
    /// The calibration, or why the one in force stays.
    pub result: Result<JointResult, Refusal>,
    /// What is known; held-out residuals are those of g_p.
    pub evidence: Evidence,
}
