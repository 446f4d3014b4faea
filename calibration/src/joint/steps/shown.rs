//! The readings' noise as the poses show it: more than was stated where something is unmodelled.

use super::step::{OUTLIER, Step};
use crate::joint::constraint::{Constraints, ReadingNoise};
use crate::joint::layout::Values;
use crate::joint::sample::JointSample;
use crate::math::sqrt;
use crate::spread::Spread;

/// A change of noise that is not worth another fit, of the noise. Derived from its own scatter: of 200 poses with three rows a
/// noise is known to 3 %.
const SAME_NOISE: f32 = 0.05;

impl ReadingNoise {
    /// Whether the difference is not worth another fit.
    pub(super) fn is_about(&self, other: &Self) -> bool {
        let same = |a: f32, b: f32| (a / b - 1.0).abs() < SAME_NOISE;
        same(self.segment_m, other.segment_m) && same(self.displacement_m, other.displacement_m)
    }
}

/// Noise as the poses show it, not below the stated: segments by g_p, deflections by what of g_x the segments leave.
#[derive(Debug)]
pub(super) struct ShownNoise {
    misclosures: [Spread; 3],
    segment_share_of_x: f32,
}

impl ShownNoise {
    pub(super) const NONE: Self = Self {
        misclosures: [Spread::EMPTY; 3],
        segment_share_of_x: 0.0,
    };

    pub(super) fn add(&mut self, constraints: &Constraints, values: &Values, sample: &JointSample) {
        let misclosure = constraints.misclosure(values, sample);
        for (spread, g) in self.misclosures.iter_mut().zip(misclosure) {
            spread.add_within(g, OUTLIER);
        }
        self.segment_share_of_x += constraints.segment_share_of_x(values, sample);
    }

    pub(super) fn noise(
        &self,
        constraints: &Constraints,
        step: Step,
        poses: usize,
    ) -> ReadingNoise {
        let stated = constraints.stated_noise;
        let segment_m = stated.segment_m.max(self.misclosures[0].deviation() / 2.0);
        if step == Step::Platen {
            return ReadingNoise {
                segment_m,
                ..constraints.noise
            };
        }
        let of_x = self.misclosures[1].deviation();
        let share = self.segment_share_of_x / poses as f32;
        let left = of_x * of_x - share * segment_m * segment_m;
        ReadingNoise {
            segment_m,
            displacement_m: stated.displacement_m.max(sqrt(left.max(0.0))),
        }
    }
}
