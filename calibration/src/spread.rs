//! Standard deviation of a stream of numbers.

use crate::math::sqrt;

/// Running mean and sum of squared deviations (Welford 1962).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    count: f32,
    mean: f32,
    squares: f32,
}

impl Spread {
    /// Of nothing.
    pub const EMPTY: Self = Self {
        count: 0.0,
        mean: 0.0,
        squares: 0.0,
    };

    /// Adds a number.
    pub fn add(&mut self, value: f32) {
        self.count += 1.0;
        let step = value - self.mean;
        self.mean += step / self.count;
        self.squares += step * (value - self.mean);
    }

    /// Adds a number unless it is further from the mean so far than `limit` deviations, once there are enough to tell.
    pub fn add_within(&mut self, value: f32, limit: f32) {
        if self.count < 16.0 || (value - self.mean).abs() <= limit * self.deviation() {
            self.add(value);
        }
    }

    /// Their mean; zero of none.
    #[must_use]
    pub fn mean(&self) -> f32 {
        self.mean
    }

    /// How many numbers.
    #[must_use]
    pub fn count(&self) -> f32 {
        self.count
    }

    /// Their standard deviation; zero of fewer than two.
    #[must_use]
    pub fn deviation(&self) -> f32 {
        if self.count < 2.0 {
            0.0
        } else {
            sqrt(self.squares / (self.count - 1.0))
        }
    }
}
