//! Sums over rests: what g_x and g_y, or g_p, have beyond a reference, with the coordinates that it may go with.

use crate::math::sqrt;

/// Numbers of a rest: one, the places along x and y, the temperature over the reference's, what g_x and g_y have beyond the
/// reference. By definition in that order.
pub(super) const ONE: usize = 0;
/// See [`ONE`].
pub(super) const ALONG: [usize; 2] = [1, 2];
/// See [`ONE`].
pub(super) const WARMER: usize = 3;
/// See [`ONE`].
pub(super) const LEFT: [usize; 2] = [4, 5];
/// See [`ONE`].
const NUMBERS: usize = 6;
const PRODUCTS: usize = NUMBERS * (NUMBERS + 1) / 2;

/// Sums of the products of each two numbers: the upper triangle, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sums([f32; PRODUCTS]);

impl Sums {
    /// None: all zeros.
    pub const ZERO: Self = Self([0.0; PRODUCTS]);

    /// Adds a rest.
    pub fn add(&mut self, numbers: [f32; NUMBERS]) {
        let mut sums = self.0.iter_mut();
        for (i, a) in numbers.iter().enumerate() {
            // The numbers first: the sum behind a row's end is the next row's.
            for (b, sum) in numbers.iter().skip(i).zip(sums.by_ref()) {
                *sum += a * b;
            }
        }
    }

    /// Older ones count less by this factor, and these as well.
    pub fn fade_in(&mut self, kept: f32, new: &Self) {
        for (sum, new) in self.0.iter_mut().zip(new.0) {
            *sum = kept * *sum + new;
        }
    }

    /// Sum of the products of two numbers, the first not behind the second.
    pub fn of(&self, i: usize, j: usize) -> f32 {
        let row = i * NUMBERS - i * i.saturating_sub(1) / 2;
        self.0.get(row + j - i).copied().unwrap_or(0.0)
    }

    /// How many rests.
    pub fn count(&self) -> f32 {
        self.of(ONE, ONE)
    }

    /// Mean of a number.
    pub fn mean(&self, i: usize) -> f32 {
        self.of(ONE, i) / self.count().max(1.0)
    }

    /// Sum of the products of two numbers about their means.
    pub fn about(&self, i: usize, j: usize) -> f32 {
        self.of(i, j) - self.mean(i) * self.of(ONE, j)
    }

    /// Of a number, its deviation about its mean.
    pub fn spread(&self, i: usize) -> f32 {
        sqrt((self.about(i, i) / self.count().max(1.0)).max(0.0))
    }

    /// Of one of [`LEFT`]: slopes along x and y, metres a unit of the place, and their variances where that of a rest is one.
    pub fn slopes(&self, left: usize) -> ([f32; 2], [f32; 2]) {
        let [x, y] = ALONG;
        let (a, b, d) = (self.about(x, x), self.about(x, y), self.about(y, y));
        let (p, q) = (self.about(x, left), self.about(y, left));
        let by = 1.0 / (a * d - b * b);
        let found_m = [by * (d * p - b * q), by * (a * q - b * p)];
        (found_m, [by * d, by * a])
    }
}
