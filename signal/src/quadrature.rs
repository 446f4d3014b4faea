//! One segment's pair: counts to unit vector, amplitude and phase; phase to tooth count.

use crate::lanes::{Bits, Lanes};
use crate::math::{self, Constants, Octants, sincos_turns};
use crate::range::{OutOfRange, within};
use core::f32::consts::TAU;
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
    /// Checks its numbers.
    ///
    /// # Errors
    /// The first one that is out of range.
    #[inline] // built with the image, for size
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let [sine, cosine] = self.offset_counts;
        within("offset_counts", sine, -32_768.0, 32_768.0)?;
        within("offset_counts", cosine, -32_768.0, 32_768.0)?;
        within("gain", self.gain, 0.1, 10.0)?;
        within("angle_rad", self.angle_rad, -1.0, 1.0)
    }

    /// Machine form of two segments' corrections.
    #[inline] // built with the image, for size
    pub(crate) fn compile(pairs: [&Self; 2]) -> CompiledPair {
        let sincos = pairs.map(|pair| sincos_turns(pair.angle_rad / TAU));
        CompiledPair {
            sine_offset: Lanes::new(|i| pairs[i].offset_counts[0]),
            cosine_offset: Lanes::new(|i| pairs[i].offset_counts[1]),
            scale: Lanes::new(|i| 1.0 / (pairs[i].gain * sincos[i].1)),
            shear: Lanes::new(|i| sincos[i].0 / sincos[i].1),
        }
    }
}

/// Two segments' [`PairCorrection`]s as the interrupt applies them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompiledPair {
    sine_offset: Lanes,
    cosine_offset: Lanes,
    scale: Lanes,
    shear: Lanes,
}

impl CompiledPair {
    /// Zeros, which are no correction: for a static.
    pub const ZERO: Self = Self {
        sine_offset: Lanes([0.0; 2]),
        cosine_offset: Lanes([0.0; 2]),
        scale: Lanes([0.0; 2]),
        shear: Lanes([0.0; 2]),
    };

    /// The first pair's correction in both lanes: of two equal lanes the compiler computes one.
    #[inline(always)]
    pub fn first_twice(&self) -> Self {
        let twice = |lanes: Lanes| Lanes([lanes.0[0]; 2]);
        Self {
            sine_offset: twice(self.sine_offset),
            cosine_offset: twice(self.cosine_offset),
            scale: twice(self.scale),
            shear: twice(self.shear),
        }
    }
}

/// Two pairs of channels after correction and interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interpolated {
    pub sine: Lanes,
    pub cosine: Lanes,
    pub amplitude: Lanes,
    /// Bits of the squared amplitude, for integer comparisons.
    pub square: Bits,
    /// Phase, -0.5 to 0.5.
    pub turns: Lanes,
}

/// Corrects and interpolates the counts of two segments; any input gives finite results. No branch.
#[inline(always)]
pub(crate) fn interpolate(
    constants: &Constants,
    octants: &Octants,
    pair: &CompiledPair,
    counts: [[i16; 2]; 2],
) -> Interpolated {
    let sine = Lanes::new(|i| f32::from(counts[i][0]));
    let cosine = Lanes::new(|i| f32::from(counts[i][1]));
    let s = sine - pair.sine_offset;
    let c = (cosine - pair.cosine_offset) * pair.scale + s * pair.shear;
    let (ss, cc) = (s * s, c * c);
    // A dead channel's zero comes out as an amplitude of zero and some phase: the inverse of zero is finite.
    let square = ss + cc;
    let inverse = constants.inverse_sqrt(square);
    let (sine, cosine) = (s * inverse, c * inverse);
    let turns = math::phase_turns(constants, octants, sine, cosine, cc - ss);
    Interpolated {
        sine,
        cosine,
        amplitude: square * inverse,
        square: square.bits(),
        turns,
    }
}

/// What the counters need to know about motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CounterLimits {
    /// Largest step from the predicted phase, turns.
    pub slip: f32,
    /// Half the share of a step in the filtered speed, m/s per turn.
    pub speed_filter: f32,
}

impl CounterLimits {
    /// For a static.
    pub const ZERO: Self = Self {
        slip: 0.0,
        speed_filter: 0.0,
    };

    /// For the first sample, which cannot slip and has no speed.
    pub const FIRST: Self = Self {
        slip: f32::INFINITY,
        speed_filter: 0.0,
    };
}

/// Tooth counts of the two segments of a pair, and their filtered speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Counters {
    pub turns: Lanes,
    pub teeth: [i32; 2],
    pub speed_m_s: f32,
}

impl Counters {
    /// Takes the phases that follow the last good ones, in which time 1 m/s goes `turns_per_m_s`; returns the new
    /// counters and all ones for each lane whose step from the predicted phase was too large to be sure of the count.
    ///
    /// Prediction: last phase plus filtered speed. A slip sets the speed to zero, so that a false one cannot persist.
    /// `teeth` moves by whole turns so that the step is the shortest; |step| < 2^22. No branch.
    #[inline(always)]
    pub fn advance(
        &self,
        constants: &Constants,
        limits: &CounterLimits,
        turns: Lanes,
        turns_per_m_s: f32,
    ) -> (Self, Bits) {
        let step = turns - self.turns - self.speed_m_s * turns_per_m_s;
        let (whole, _) = constants.nearest(step);
        let rest = step - whole;
        let slip = rest.bits().map(|bits| above(bits, limits.slip.to_bits()));
        let filtered = self.speed_m_s + (rest.0[0] + rest.0[1]) * limits.speed_filter;
        let counters = Self {
            turns,
            teeth: [0, 1].map(|i| self.teeth[i].wrapping_sub(whole.0[i] as i32)),
            speed_m_s: f32::from_bits(filtered.to_bits() & !(slip[0] | slip[1])),
        };
        (counters, slip)
    }
}

/// Direction of travel: the sign of a speed outside the dead band, else the old one.
#[inline(always)]
pub(crate) fn direction(old: f32, speed_m_s: f32, dead_band_m_s: f32) -> f32 {
    let moving = above(speed_m_s.to_bits(), dead_band_m_s.to_bits());
    let sign = (speed_m_s.to_bits() & SIGN) | 1.0_f32.to_bits();
    f32::from_bits(old.to_bits() ^ ((old.to_bits() ^ sign) & moving))
}

/// The sign of an f32, by definition its first bit.
const SIGN: u32 = 0x8000_0000;

/// All ones if the magnitude of an f32 (its bits) is above a limit that is not negative, or the value is not a number.
#[inline(always)]
pub(crate) fn above(bits: u32, limit: u32) -> u32 {
    ((limit as i32).wrapping_sub((bits & !SIGN) as i32) >> 31) as u32
}
