//! What a pose under the beacon leaves behind, and the buffer of them.

use crate::calibration::sample::Sample;
use crate::frame::{Coordinate, SEGMENTS};
use crate::model::Observation;

/// Poses in the buffer, fitted and held out. 32 bytes each.
pub const POSES: usize = 1280;

/// One pose: unmodified outputs relative to the origin's teeth, and the deflection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSample {
    /// Phases, turns.
    pub fraction_turns: [f32; SEGMENTS],
    /// Measured deflection of the coordination sensor, 1 at full scale.
    pub deflection: [f32; 2],
    /// Whole teeth from the origin's.
    pub teeth: [i16; SEGMENTS],
}

impl JointSample {
    /// Nothing.
    pub const ZERO: Self = Self {
        fraction_turns: [0.0; SEGMENTS],
        deflection: [0.0; 2],
        teeth: [0; SEGMENTS],
    };

    /// From a pose's averages; `None` if it is more than 32,767 teeth from the origin.
    #[must_use]
    pub fn new(
        origin_teeth: &[i32; SEGMENTS],
        sample: &Sample,
        deflection: [f32; 2],
    ) -> Option<Self> {
        let mut out = Self {
            deflection,
            ..Self::ZERO
        };
        for (i, output) in sample.unmodified.iter().enumerate() {
            out.teeth[i] = i16::try_from(output.teeth.wrapping_sub(origin_teeth[i])).ok()?;
            out.fraction_turns[i] = output.fraction_turns;
        }
        Some(out)
    }

    pub(super) fn observation(&self) -> Observation {
        let mut seen = Observation::default();
        for (i, p) in seen.unmodified.iter_mut().enumerate() {
            *p = Coordinate {
                teeth: self.teeth[i].into(),
                fraction_turns: self.fraction_turns[i],
            };
        }
        seen
    }

    /// Outputs from the origin, turns: exact to f32 within some hundred teeth.
    pub(super) fn turns(&self) -> [f32; SEGMENTS] {
        core::array::from_fn(|i| f32::from(self.teeth[i]) + self.fraction_turns[i])
    }
}

/// Poses in the order of their visit; from `held_out_from` on they are not fitted.
#[derive(Clone, Debug)]
pub struct JointBuffer {
    samples: [JointSample; POSES],
    count: usize,
    held_out_from: usize,
}

impl Default for JointBuffer {
    fn default() -> Self {
        Self::new()
    }
}

impl JointBuffer {
    /// Nothing collected.
    // A function: a constant of this size would lie in the image's flash, zeros and all.
    pub const fn new() -> Self {
        Self {
            samples: [JointSample::ZERO; POSES],
            count: 0,
            held_out_from: POSES,
        }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        (self.count, self.held_out_from) = (0, POSES);
    }

    /// Adds a pose; false if there is no room.
    pub fn push(&mut self, sample: JointSample) -> bool {
        let Some(place) = self.samples.get_mut(self.count) else {
            return false;
        };
        *place = sample;
        self.count += 1;
        true
    }

    /// What comes after is held out.
    pub fn hold_out_rest(&mut self) {
        self.held_out_from = self.count;
    }

    /// Poses to fit.
    #[must_use]
    pub fn fitted(&self) -> &[JointSample] {
        &self.samples[..self.count.min(self.held_out_from)]
    }

    /// Poses that decide.
    #[must_use]
    pub fn held_out(&self) -> &[JointSample] {
        &self.samples[self.count.min(self.held_out_from)..self.count]
    }
}
