//! The coordination sensor: four electrode counts of a lateral-effect diode to tan psi.

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

/// tan psi of both axes, and what is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deflection {
    pub tan_psi: [f32; 2],
    pub missing: bool,
    pub saturated: bool,
}

/// `full_scale * (plus - minus) / (plus + minus)` per axis, zero without a beacon. One division for both axes.
#[inline(always)]
pub(crate) fn deflection(limits: &BeaconLimits, full_scale: f32, counts: [i16; 4]) -> Deflection {
    let [xp, xm, yp, ym] = counts.map(i32::from);
    let (sum_x, sum_y) = (xp + xm, yp + ym);
    let missing = sum_x < limits.sum_low_counts || sum_y < limits.sum_low_counts;
    let limit = i32::from(limits.clip_counts);
    let saturated = [xp, xm, yp, ym]
        .iter()
        .fold(false, |hit, &v| hit | (v >= limit) | (v <= -limit));
    let (sum_x, sum_y) = if missing { (1, 1) } else { (sum_x, sum_y) };
    let full_scale = if missing { 0.0 } else { full_scale };
    let (sum_x, sum_y) = (sum_x as f32, sum_y as f32);
    let factor = full_scale / (sum_x * sum_y);
    Deflection {
        tan_psi: [
            (xp - xm) as f32 * sum_y * factor,
            (yp - ym) as f32 * sum_x * factor,
        ],
        missing,
        saturated,
    }
}
