//! Page's test for each of g_x and g_y, its value at the middle and its slopes, up and down.

use crate::watch::{LEFT_ALONE, MOST, WatchConfig};

/// Tests. By definition two axes, three numbers of each, two signs.
pub(super) const TESTS: usize = 12;

/// Their sums. That of all tests passes [`WatchConfig::SCORE`], 22, by chance once in `e^22 / 12` windows at most, which are of 16 rests: once
/// in 80,000 hours at one a second (Lorden 1971). The same score as for segments, which is more than is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scores([f32; TESTS]);

impl Scores {
    /// Nothing.
    pub const ZERO: Self = Self([0.0; TESTS]);

    /// Adds what a window found of a number, of this variance; `told_m` of it is told.
    pub fn add(&mut self, axis: usize, number: usize, found_m: f32, variance: f32, told_m: f32) {
        let left_alone_m = LEFT_ALONE * told_m;
        let by = (told_m - left_alone_m) / variance;
        let middle_m = 0.5 * (told_m + left_alone_m);
        for (sign, place) in [1.0, -1.0].into_iter().zip(0..) {
            let Some(sum) = self.0.get_mut(6 * axis + 2 * number + place) else {
                continue;
            };
            let grown = *sum + by * (sign * found_m - middle_m);
            #[allow(clippy::manual_clamp)] // not a number counts as nothing
            let bounded = grown.max(0.0).min(MOST);
            *sum = bounded;
        }
    }

    /// As when a change was told, of which it is not known any more which.
    pub fn told(axis: usize) -> Self {
        let mut scores = Self::ZERO;
        if let Some(sum) = scores.0.get_mut(6 * axis) {
            *sum = WatchConfig::SCORE;
        }
        scores
    }

    /// The largest sum of an axis, of that at which a change is told.
    pub fn evidence(&self, axis: usize) -> f32 {
        let of_axis = self.0.iter().skip(6 * axis).take(6);
        of_axis.fold(0.0, |most: f32, sum| most.max(*sum)) / WatchConfig::SCORE
    }
}
