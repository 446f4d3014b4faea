//! How far the courier turns, by what both pairs of segments have in common.

use crate::frame::{Coordinate, SEGMENTS};

/// Sums over readings of the difference of each pair's outputs, turns, and of their product. Each pair's has its segments' own errors in it,
/// tens of micrometres, and the two pairs' are not alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turning {
    sums: [f32; 2],
    product: f32,
}

impl Turning {
    /// None yet.
    pub const ZERO: Self = Self {
        sums: [0.0; 2],
        product: 0.0,
    };

    /// Adds a reading.
    pub fn note(&mut self, [p1, p2, p3, p4]: &[Coordinate; SEGMENTS]) {
        let (x, y) = (p1.minus_turns(*p3), p2.minus_turns(*p4));
        self.sums[0] += x;
        self.sums[1] += y;
        self.product += x * y;
    }

    /// Covariance of both differences over so many readings, turns squared.
    pub fn variance(&self, readings: u32) -> f32 {
        let count = readings.max(1) as f32;
        let [x, y] = self.sums.map(|sum| sum / count);
        self.product / count - x * y
    }
}
