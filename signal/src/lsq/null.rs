//! A direction along which a factor is as good as zero, by inverse iteration.

use super::givens::hypot;
use super::packed;
use super::spectrum::start_vector;
use super::upper::Factor;
use crate::math::sqrt;

/// Iterations at least. Derived from the ratio of the two weakest directions: what is 1.5 times as strong as the direction is
/// then below 1.5^-16 = 0.002 of the vector.
const LEAST: usize = 8;
/// And at most. A bound on the work: the vector is then told as it is, from among directions that are about as weak.
const MOST: usize = 100;

impl Factor<'_> {
    /// Writes to `v` the direction of the smallest singular value, or, where several are below `bound`, one from among
    /// theirs: the factor makes less than `bound` of it. `largest` sets the floor under the diagonal.
    pub fn null_direction(self, bound: f32, largest: f32, v: &mut [f32]) {
        let floor = (largest * 1.0e-9).max(f32::MIN_POSITIVE);
        start_vector(v);
        for iteration in 1..=MOST {
            let forward = self.forward_floored(v, floor);
            let backward = self.backward_floored(v, floor);
            if iteration >= LEAST && sqrt(forward) * sqrt(backward) <= bound {
                break;
            }
        }
    }

    /// `v <- R^-T v`, brought to length one; returns the inverse of the length it had.
    fn forward_floored(self, v: &mut [f32], floor: f32) -> f32 {
        let mut shrunk = 1.0;
        for i in 0..self.unknowns {
            let row = self.row(i);
            let y = v[i] / row[0].max(floor);
            v[i] = y;
            packed::subtract(&mut v[i + 1..], y, &row[1..]);
            shrunk *= limit(v, i);
        }
        shrunk / normalise(v)
    }

    /// `v <- R^-1 v`, brought to length one; returns the inverse of the length it had.
    fn backward_floored(self, v: &mut [f32], floor: f32) -> f32 {
        let mut shrunk = 1.0;
        for i in (0..self.unknowns).rev() {
            let row = self.row(i);
            let sum = packed::dot(&row[1..], &v[i + 1..]);
            v[i] = (v[i] - sum) / row[0].max(floor);
            shrunk *= limit(v, i);
        }
        shrunk / normalise(v)
    }
}

/// Shrinks the whole vector where entry `i` has grown near overflow; returns the factor.
fn limit(v: &mut [f32], i: usize) -> f32 {
    /// What a vector is shrunk by. Derived from f32's largest number, 3e38: the square of what has grown to 1e12 is far below it.
    const SHRINK: f32 = 1.0e-12;
    if v[i].abs() < 1.0 / SHRINK {
        return 1.0;
    }
    v.iter_mut().for_each(|v| *v *= SHRINK);
    SHRINK
}

/// Length of `v`, without overflow or loss.
pub(super) fn norm(v: &[f32]) -> f32 {
    v.iter().fold(0.0, |length, x| hypot(length, *x))
}

/// Brings `v` to length one; returns the length it had.
fn normalise(v: &mut [f32]) -> f32 {
    let length = norm(v);
    if length > 0.0 {
        v.iter_mut().for_each(|x| *x /= length);
    }
    length
}
