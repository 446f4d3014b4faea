//! What a calibration left in g_x and g_y, by the first rests.

use super::rest::Visit;
use super::sums::{LEFT, Sums, WARMER};
use crate::geometry::Geometry;
use crate::math::{round, sqrt};
use crate::record::Beacon;

/// The reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Reference {
    /// g_x and g_y, metres; whole teeth are not known.
    pub offset_m: [f32; 2],
    /// What is left of a rest about it, metres.
    pub sigma_m: [f32; 2],
    /// Its temperature over the calibration's, kelvin.
    pub temperature_k: f32,
}

impl Reference {
    /// All zeros.
    pub const ZERO: Self = Self {
        offset_m: [0.0; 2],
        sigma_m: [0.0; 2],
        temperature_k: 0.0,
    };

    /// Of rests whose residuals are against this one, the sigma of which is the least that is believed: what all of the calibration's poses
    /// showed. Rests of one place may differ by less.
    pub fn of(&self, sums: &Sums) -> Self {
        let mut found = *self;
        for ((left, offset_m), sigma_m) in LEFT
            .into_iter()
            .zip(&mut found.offset_m)
            .zip(&mut found.sigma_m)
        {
            let square = sums.about(left, left) / sums.count().max(1.0);
            *offset_m += sums.mean(left);
            *sigma_m = sigma_m.max(sqrt(square.max(0.0)));
        }
        found.temperature_k += sums.mean(WARMER);
        found
    }

    /// What a rest has beyond it, metres, to the nearest whole tooth.
    pub fn left_m(&self, visit: &Visit, pitch_m: f32) -> [f32; 2] {
        [0, 1].map(|axis| {
            let left_m = visit.g_m[axis] - self.offset_m[axis];
            let (teeth, _) = round(left_m / pitch_m);
            left_m - teeth * pitch_m
        })
    }
}

/// Standard deviations of g_x and g_y as a joint calibration states its readings', metres: a mean of two segments, a displacement, and the angle
/// at the lever arm.
#[must_use]
pub fn stated_m(beacon: &Beacon, geometry: &Geometry) -> [f32; 2] {
    let (segment, displacement) = (beacon.segment_sd_m, beacon.displacement_sd_m);
    let [lever_x, lever_y] = geometry.lever_m.map(|lever_m| lever_m / geometry.span_m);
    [lever_y, lever_x].map(|by_angle| {
        let share = 0.5 + by_angle * by_angle;
        sqrt(share * segment * segment + displacement * displacement)
    })
}
