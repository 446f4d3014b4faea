//! Which poses a calibration visited, in few bytes: what its generator was told, and where it began.

use crate::frame::{Coordinate, SEGMENTS};
use crate::math::round;
use crate::plan::{Plan, Range};
use crate::sample::Sample;
use serde::{Deserialize, Serialize};

/// Steps of a tooth in which a start is kept. Derived from the highest order: a step is 8 degrees of order 6, and half of that is the most that a
/// function of equation (3) is off by, alike at all poses.
const STEPS: f32 = 256.0;

/// What makes the poses of a platen calibration again. With its coefficients it tells the rows of its fit, and so their covariance, which would take
/// a kilobyte.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Poses {
    /// How they were chosen.
    pub plan: Plan,
    /// Of the pose generator.
    pub seed: u64,
    /// Where poses were drawn from.
    pub range: Range,
    /// Poses that were visited for the fit, whether they were of use or not.
    pub visited: u16,
    /// Poses held out that were of use.
    pub held_out: u16,
    /// Where in its tooth each segment read at the start, in steps of 1/256 of a pitch.
    start: [u8; SEGMENTS],
}

impl Poses {
    /// Of a session from a start, with so many poses visited and held out.
    #[must_use]
    pub fn new(plan: Plan, seed: u64, range: Range, start: &Sample, counts: [u16; 2]) -> Self {
        let [visited, held_out] = counts;
        Self {
            plan,
            seed,
            range,
            visited,
            held_out,
            start: start
                .unmodified
                .map(|output| round(STEPS * output.fraction_turns).1 as u8),
        }
    }

    /// The start, its whole teeth aside.
    #[must_use]
    pub fn start(&self) -> Sample {
        let coordinate = |step: u8| Coordinate {
            teeth: 0,
            fraction_turns: f32::from(step.cast_signed()) / STEPS,
        };
        Sample {
            unmodified: self.start.map(coordinate),
            ..Sample::ZERO
        }
    }
}
