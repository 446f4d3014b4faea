//! One Givens rotation: makes the first entry of a row vanish against a diagonal entry.

use crate::math::sqrt;

/// Squares of values in this range neither overflow nor lose bits that matter beside each other.
const SAFE: core::ops::Range<f32> = 1.0e-24..1.0e24;

/// Plane rotation `[c s; -s c]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotation {
    pub c: f32,
    pub s: f32,
}

impl Rotation {
    /// Rotation that takes `(pivot, entry)` to `(radius, 0)`, and the radius (never negative). `pivot` is not
    /// negative and `entry` is not zero.
    pub fn new(pivot: f32, entry: f32) -> (Self, f32) {
        let square = pivot * pivot + entry * entry;
        if SAFE.contains(&square) {
            let radius = sqrt(square);
            let inverse = 1.0 / radius;
            (
                Self {
                    c: pivot * inverse,
                    s: entry * inverse,
                },
                radius,
            )
        } else {
            Self::scaled(pivot, entry)
        }
    }

    /// The same for values whose squares leave f32's range: both are divided by the larger.
    #[cold]
    fn scaled(pivot: f32, entry: f32) -> (Self, f32) {
        let large = if pivot > entry.abs() {
            pivot
        } else {
            entry.abs()
        };
        let (pivot, entry) = (pivot / large, entry / large);
        let norm = sqrt(pivot * pivot + entry * entry);
        (
            Self {
                c: pivot / norm,
                s: entry / norm,
            },
            large * norm,
        )
    }

    /// Turns one pair.
    #[inline(always)]
    pub fn turn(self, factor: &mut f32, entry: &mut f32) {
        let (f, e) = (*factor, *entry);
        *factor = self.c * f + self.s * e;
        *entry = self.c * e - self.s * f;
    }
}

/// `sqrt(a^2 + b^2)` without overflow or loss.
#[inline]
pub(super) fn hypot(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        a.abs()
    } else {
        Rotation::new(a, b).1
    }
}
