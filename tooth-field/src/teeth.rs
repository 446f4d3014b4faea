//! What a diagnosis found of a platen's teeth.

use crate::kernel::ApertureKernel;
use crate::lattice::Lattice;
use serde::{Deserialize, Serialize};

/// Teeth that a recording passed, and how its segments read them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Teeth {
    /// What a reading averages over.
    #[serde(rename = "footprint")]
    pub aperture: ApertureKernel,
    /// Pitches from one amount to the next along and across a segment: 1, or more under an aperture that blurs single teeth.
    pub step_pitches: [f64; 2],
    /// Prior deviation of a tooth's displacement and of a whole line's, m.
    pub deviation_m: [f64; 2],
    /// Teeth along and across in such steps, displaced along x (seen by segments 1 and 3) and along y (2 and 4).
    pub posts: [Vec<[i32; 2]>; 2],
    /// Whole lines of them.
    pub lines: [Vec<i32>; 2],
}

impl Teeth {
    /// The lattice that they are nodes of.
    #[must_use]
    pub fn lattice(&self) -> Lattice<ApertureKernel> {
        Lattice {
            kernel: self.aperture,
            step_pitches: self.step_pitches,
        }
    }
}
