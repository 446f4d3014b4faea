//! What a pose under the beacon leaves behind, and the buffer of them.

use crate::frame::{Coordinate, SEGMENTS};
use crate::model::Observation;
use crate::sample::Sample;

/// Poses in the buffer, fitted and held out. A bound on the work: more are refused when they are ordered; 24 bytes each are what
/// RAM is left.
pub const POSES: usize = 1200;
/// Farthest from the origin's teeth that a stored output may be. Derived from the fraction's 22 bits, which leave ten for the
/// teeth and their sign.
pub const FARTHEST_TEETH: i16 = 500;
/// Binary places of a stored output's fraction. Derived from the resolution of 0.2 µm (paper, section 1): 2^-22 of a pitch of
/// 1.016 mm is 0.24 nm, 0.07 nm rms.
const FRACTION_BITS: u32 = 22;
const STEPS_PER_PITCH: f32 = (1 << FRACTION_BITS) as f32;

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

/// Outputs of a pose as they are stored: steps of 2^-22 of a pitch, counted from the origin's teeth.
type Stored = [i32; SEGMENTS];

/// `None` if an output is more than [`FARTHEST_TEETH`] from the origin, or no number.
fn stored(sample: &JointSample) -> Option<Stored> {
    let mut outputs = [0; SEGMENTS];
    for (i, output) in outputs.iter_mut().enumerate() {
        let (teeth, fraction) = (sample.teeth[i], sample.fraction_turns[i]);
        let near = teeth.unsigned_abs() <= FARTHEST_TEETH.unsigned_abs();
        if !near || !(-1.0..=1.0).contains(&fraction) {
            return None;
        }
        let steps = fraction * STEPS_PER_PITCH;
        let rounded = (steps + if steps < 0.0 { -0.5 } else { 0.5 }) as i32;
        *output = (i32::from(teeth) << FRACTION_BITS) + rounded;
    }
    Some(outputs)
}

fn sample(outputs: &Stored, deflection: &[f32; 2]) -> JointSample {
    const HALF: i32 = 1 << (FRACTION_BITS - 1);
    let teeth = outputs.map(|steps| (steps + HALF) >> FRACTION_BITS);
    JointSample {
        fraction_turns: core::array::from_fn(|i| {
            (outputs[i] - (teeth[i] << FRACTION_BITS)) as f32 / STEPS_PER_PITCH
        }),
        deflection: *deflection,
        teeth: teeth.map(|whole| whole as i16), // at most FARTHEST_TEETH + 1
    }
}

/// Poses that can be walked again and again: a part of a buffer, or a slice's `iter().copied()`.
pub trait Poses: Clone + ExactSizeIterator<Item = JointSample> {}

impl<I: Clone + ExactSizeIterator<Item = JointSample>> Poses for I {}

/// Poses in the order of their visit; from `held_out_from` on they are not fitted.
#[derive(Clone, Debug)]
pub struct JointBuffer {
    outputs: [i32; SEGMENTS * POSES],
    deflections: [f32; 2 * POSES],
    count: usize,
    /// Poses to fit, once they are complete.
    fitted: usize,
    is_complete: bool,
}

impl Default for JointBuffer {
    fn default() -> Self {
        Self::new()
    }
}

impl JointBuffer {
    /// Nothing collected: all zeros, so that as a constant it is a clearing of memory in its place.
    pub const fn new() -> Self {
        Self {
            outputs: [0; SEGMENTS * POSES],
            deflections: [0.0; 2 * POSES],
            count: 0,
            fitted: 0,
            is_complete: false,
        }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        (self.count, self.is_complete) = (0, false);
    }

    /// Adds a pose, its outputs rounded to 2^-22 of a pitch; false if there is no room, or an output is no number or more than
    /// [`FARTHEST_TEETH`] from the origin's.
    pub fn push(&mut self, sample: JointSample) -> bool {
        let outputs = self.outputs.as_chunks_mut().0.get_mut(self.count);
        let deflections = self.deflections.as_chunks_mut().0.get_mut(self.count);
        let (Some(output), Some(deflection), Some(stored)) =
            (outputs, deflections, stored(&sample))
        else {
            return false;
        };
        (*output, *deflection) = (stored, sample.deflection);
        self.count += 1;
        true
    }

    /// What comes after is held out.
    pub fn hold_out_rest(&mut self) {
        (self.fitted, self.is_complete) = (self.count, true);
    }

    /// Poses to fit.
    #[must_use]
    pub fn fitted(&self) -> Part<'_> {
        self.part(0, self.fits())
    }

    /// Poses that decide.
    #[must_use]
    pub fn held_out(&self) -> Part<'_> {
        self.part(self.fits(), self.count)
    }

    fn part(&self, from: usize, to: usize) -> Part<'_> {
        let outputs = self.outputs.as_chunks().0.get(from..to);
        let deflections = self.deflections.as_chunks().0.get(from..to);
        Part {
            outputs: outputs.unwrap_or_default(),
            deflections: deflections.unwrap_or_default(),
        }
    }

    fn fits(&self) -> usize {
        if self.is_complete {
            self.fitted
        } else {
            self.count
        }
    }
}

/// Some of a buffer's poses.
#[derive(Clone, Copy, Debug)]
pub struct Part<'b> {
    outputs: &'b [Stored],
    deflections: &'b [[f32; 2]],
}

impl Part<'_> {
    /// One of them, by its place.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<JointSample> {
        Some(sample(
            self.outputs.get(index)?,
            self.deflections.get(index)?,
        ))
    }
}

impl Iterator for Part<'_> {
    type Item = JointSample;

    fn next(&mut self) -> Option<JointSample> {
        let first = self.get(0)?;
        self.outputs = self.outputs.get(1..)?;
        self.deflections = self.deflections.get(1..)?;
        Some(first)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.outputs.len(), Some(self.outputs.len()))
    }
}

impl ExactSizeIterator for Part<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stored_pose_is_the_same_to_half_a_step() {
        let mut buffer = JointBuffer::new();
        for n in 0..1000i16 {
            let fraction = f32::from(n - 500) * 0.001_003;
            let sample = JointSample {
                fraction_turns: [fraction, -fraction, 0.5, -0.5],
                deflection: [0.123, -fraction],
                teeth: [n - 500, 500 - n, 499, -500],
            };
            assert!(buffer.push(sample));
            let back = buffer.fitted().last().unwrap();
            for (a, b) in sample.turns_exactly().iter().zip(back.turns_exactly()) {
                assert!((a - b).abs() <= 0.5 / f64::from(STEPS_PER_PITCH), "{a} {b}");
            }
            assert_eq!(back.deflection, sample.deflection);
        }
    }

    #[test]
    fn what_cannot_be_stored_is_told() {
        let mut buffer = JointBuffer::new();
        let far = JointSample {
            teeth: [0, 0, FARTHEST_TEETH + 1, 0],
            ..JointSample::ZERO
        };
        let none = JointSample {
            fraction_turns: [f32::NAN; SEGMENTS],
            ..JointSample::ZERO
        };
        assert!(!buffer.push(far) && !buffer.push(none));
        for _ in 0..POSES {
            assert!(buffer.push(JointSample::ZERO));
        }
        assert!(!buffer.push(JointSample::ZERO));
        buffer.hold_out_rest();
        assert_eq!((buffer.fitted().len(), buffer.held_out().len()), (POSES, 0));
    }

    impl JointSample {
        fn turns_exactly(&self) -> [f64; SEGMENTS] {
            core::array::from_fn(|i| f64::from(self.teeth[i]) + f64::from(self.fraction_turns[i]))
        }
    }
}
