//! Page's test for every place and direction of a wave.
//!
//! A wave of amplitude `told` or more against one of amplitude `left_alone` or less, along one of twelve directions `u` in the plane of
//! sine and cosine: the logarithm of the likelihood ratio of a window's amounts `x`, of deviation `s`, is
//!
//! ```text
//! (told - left_alone) (u x - (told + left_alone) / 2) / s^2
//! ```
//!
//! of which the expected exponential is one at most whatever wave up to `left_alone` there is. Its sums, each cut off at zero, pass `h` by
//! chance once in `e^h` windows at most (Lorden 1971); of all 192 together once in `e^h / 192`.

use super::config::{Bounds, WatchConfig};
use serde::{Deserialize, Serialize};

/// Directions. Derived from the cosine: none is further than a twelfth of a half turn from the nearest, where 0.97 of a wave is
/// seen.
const DIRECTIONS: usize = 12;
/// The cosine of 30°, by definition half the root of three.
const COSINE_30: f32 = 0.866_025_4;
const UNITS: [[f32; 2]; DIRECTIONS] = [
    [1.0, 0.0],
    [COSINE_30, 0.5],
    [0.5, COSINE_30],
    [0.0, 1.0],
    [-0.5, COSINE_30],
    [-COSINE_30, 0.5],
    [-1.0, 0.0],
    [-COSINE_30, -0.5],
    [-0.5, -COSINE_30],
    [0.0, -1.0],
    [0.5, -COSINE_30],
    [COSINE_30, -0.5],
];
/// A sum grows no further, so that what goes away again is not told for ever. A prior: twice what a change is told at.
pub(crate) const MOST: f32 = 2.0 * WatchConfig::SCORE;
/// Of a sum's stored unit in one: what is stored is rounded down, a quarter at most at a window that adds twenty. Derived from
/// the byte that it has room for.
const UNIT: f32 = 4.0;
const _: () = assert!(MOST * UNIT < 256.0);

/// Sums of one place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Scores([u8; DIRECTIONS]);

impl Scores {
    /// Nothing.
    pub const ZERO: Self = Self([0; DIRECTIONS]);

    /// Adds a window's amounts, metres, of this variance.
    pub fn add(&mut self, amounts_m: [f32; 2], variance: f32, bounds: Bounds) {
        let by = (bounds.told_m - bounds.left_alone_m) / variance;
        for (sum, [u, v]) in self.0.iter_mut().zip(UNITS) {
            let along_m = u * amounts_m[0] + v * amounts_m[1];
            let ratio = by * (along_m - bounds.middle_m());
            let grown = f32::from(*sum) / UNIT + ratio;
            #[allow(clippy::manual_clamp)] // not a number counts as nothing
            let bounded = grown.max(0.0).min(MOST);
            // Rounded down.
            *sum = (bounded * UNIT) as u8;
        }
    }

    /// As when a change was told, of which the direction is not known any more.
    pub const fn told(score: f32) -> Self {
        Self([(score * UNIT) as u8; DIRECTIONS])
    }

    /// The largest sum.
    #[must_use]
    pub fn largest(&self) -> f32 {
        let largest = self.0.iter().copied().max().unwrap_or(0);
        f32::from(largest) / UNIT
    }
}
