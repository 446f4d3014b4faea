//! The coordination sensor: four electrode counts of a lateral-effect diode to tan psi.

use crate::frame::Status;
use crate::lanes::Lanes;
use serde::{Deserialize, Serialize};

/// When the electrodes' reading is to be believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeaconLimits {
    /// Each axis' sum of electrodes below this means that there is no beacon, counts; at least 1.
    pub sum_low_counts: i32,
    /// An electrode of this magnitude or above sits at the converter's end, counts.
    pub clip_counts: i16,
}

impl Default for BeaconLimits {
    fn default() -> Self {
        Self {
            sum_low_counts: 1000,
            clip_counts: 32_760,
        }
    }
}

/// [`BeaconLimits`] as the interrupt applies them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompiledBeacon {
    sum_low_counts: i32,
    /// Largest square of a count that is not clipped.
    clip_square: i32,
    full_scale: f32,
}

impl CompiledBeacon {
    /// Zeros, for a static.
    pub const ZERO: Self = Self {
        sum_low_counts: 0,
        clip_square: 0,
        full_scale: 0.0,
    };
}

impl BeaconLimits {
    /// With tan(psi) at a normalised deflection of 1.
    #[inline] // built with the image, for size
    pub(crate) fn compile(&self, full_scale: f32) -> CompiledBeacon {
        let clip_counts = i32::from(self.clip_counts);
        CompiledBeacon {
            sum_low_counts: self.sum_low_counts,
            clip_square: clip_counts * clip_counts - 1,
            full_scale,
        }
    }
}

/// tan psi of both axes, and the status bits that go with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deflection {
    pub tan_psi: [f32; 2],
    pub bits: u32,
}

/// `full_scale * (plus - minus) / (plus + minus)` per axis, zero without a beacon. One division for both axes, no branch.
#[inline(always)]
pub(crate) fn deflection(limits: &CompiledBeacon, counts: [i16; 4]) -> Deflection {
    let [xp, xm, yp, ym] = counts.map(i32::from);
    let sums = [xp + xm, yp + ym];
    let missing = ((sums[0] - limits.sum_low_counts) | (sums[1] - limits.sum_low_counts)) >> 31;
    let limit = limits.clip_square;
    let saturated =
        ((limit - xp * xp) | (limit - xm * xm) | (limit - yp * yp) | (limit - ym * ym)) >> 31;
    // All ones where the beacon is missing: the sums become 1, the full scale 0.
    let sum = Lanes(sums.map(|sum| ((sum & !missing) - missing) as f32));
    let factor =
        f32::from_bits(limits.full_scale.to_bits() & !missing as u32) / (sum.0[0] * sum.0[1]);
    let difference = Lanes([(xp - xm) as f32, (yp - ym) as f32]);
    let tan_psi = difference * Lanes([sum.0[1], sum.0[0]]) * factor;
    let bits = missing as u32 & Status::BEACON_MISSING.bits()
        | saturated as u32 & Status::BEACON_SATURATED.bits();
    Deflection {
        tan_psi: tan_psi.0,
        bits,
    }
}
