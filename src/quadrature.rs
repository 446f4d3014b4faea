//! One segment's pair: counts to unit vector, amplitude and phase; phase to tooth count.

use crate::math;
use serde::{Deserialize, Serialize};

/// Known errors of a pair's two channels, removed before interpolation. The default removes nothing.
///
/// Model: `sine = offset[0] + A sin(phi)`, `cosine = offset[1] + A gain cos(phi + angle)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairCorrection {
    /// Offsets of sine and cosine channel, counts.
    pub offset_counts: [f32; 2],
    /// Amplitude of the cosine channel over that of the sine channel.
    pub gain: f32,
    /// How far the channels are from a right angle, radians.
    pub angle_rad: f32,
}

impl Default for PairCorrection {
    fn default() -> Self {
        Self {
            offset_counts: [0.0; 2],
            gain: 1.0,
            angle_rad: 0.0,
        }
    }
}

impl PairCorrection {
    /// Machine form: offsets, factor of the cosine channel, share of the sine channel to add to it.
    pub(crate) fn compile(&self) -> CompiledPair {
        CompiledPair {
            offset: self.offset_counts,
            scale: 1.0 / (self.gain * libm::cosf(self.angle_rad)),
            shear: libm::tanf(self.angle_rad),
        }
    }
}

/// [`PairCorrection`] as the interrupt applies it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompiledPair {
    offset: [f32; 2],
    scale: f32,
    shear: f32,
}

/// A pair after correction and interpolation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Interpolated {
    pub sine: f32,
    pub cosine: f32,
    pub amplitude: f32,
    pub turns: f32,
}

/// Corrects and interpolates one pair of counts; any input gives finite results. No branch.
#[inline(always)]
pub(crate) fn interpolate(pair: &CompiledPair, counts: [i16; 2]) -> Interpolated {
    let s = counts[0] as f32 - pair.offset[0];
    let c = (counts[1] as f32 - pair.offset[1]) * pair.scale + s * pair.shear;
    // A dead channel must not divide by zero; below 1e-7 counts² the term is far under f32's last place of a live one.
    let square = s * s + c * c + 1.0e-6;
    let inverse = math::inverse_sqrt(square);
    let (sine, cosine) = (s * inverse, c * inverse);
    Interpolated {
        sine,
        cosine,
        amplitude: square * inverse,
        turns: math::phase_turns(sine, cosine),
    }
}

/// Tooth counter and speed of one segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ToothCounter {
    pub turns: f32,
    pub teeth: i32,
    /// Filtered speed, turns a sample.
    pub speed: f32,
    /// Last direction of travel outside the dead band: -1, 0 (none yet) or 1.
    pub direction: f32,
}

/// What the counter needs to know about motion, in turns and samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CounterLimits {
    pub slip: f32,
    pub speed_filter: f32,
    pub dead_band: f32,
}

impl ToothCounter {
    /// Takes the phase of a sample `elapsed` samples after the last good one (0: the same instant again) and returns
    /// whether the step from the predicted phase was too large to be sure of the count.
    ///
    /// Prediction: last phase plus filtered speed. A slip sets the speed to zero, so that a false one cannot persist.
    #[inline(always)]
    pub fn advance(&mut self, limits: &CounterLimits, turns: f32, elapsed: f32) -> bool {
        let step = turns - self.turns - self.speed * elapsed;
        let (whole, teeth) = math::round(step);
        let rest = step - whole;
        let slip = rest.to_bits() << 1 > limits.slip.to_bits() << 1;
        let speed = self.speed + limits.speed_filter * rest;
        self.turns = turns;
        self.teeth = self.teeth.wrapping_sub(teeth);
        self.speed = if slip { 0.0 } else { speed };
        let moving = self.speed.to_bits() << 1 > limits.dead_band.to_bits() << 1;
        let sign = f32::from_bits(1.0_f32.to_bits() | (self.speed.to_bits() & 0x8000_0000));
        self.direction = if moving { sign } else { self.direction };
        slip
    }
}
