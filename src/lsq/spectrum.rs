//! Largest and smallest singular value of a triangle, by power and inverse iteration.

use super::packed;
use super::upper::Upper;
use crate::math::sqrt;

/// Power and inverse iterations at most; they stop when the estimate changes by less than [`SETTLED`].
const ITERATIONS: usize = 300;
const SETTLED: f32 = 1.0e-6;
/// And not before so many: an estimate rests for some iterations on a neighbour of the direction that is sought.
const LEAST: usize = 100;

impl<const N: usize, const P: usize> Upper<N, P> {
    /// Of the scaled factor, by power iteration on `R^T R` through products with `R` and `R^T`.
    pub(super) fn largest_singular_value(&self) -> f32 {
        let mut v = start_vector::<N>(self.unknowns);
        let mut value = 0.0;
        for iteration in 0..ITERATIONS {
            self.multiply(&mut v);
            let length = norm(&v[..self.unknowns]);
            self.multiply_transposed(&mut v);
            if normalise(&mut v[..self.unknowns]) == 0.0
                || iteration >= LEAST && (length - value).abs() <= SETTLED * length
            {
                return length;
            }
            value = length;
        }
        value
    }

    /// Of the scaled factor, with its right vector, by inverse iteration. `largest` sets the floor under its diagonal.
    pub(super) fn smallest_singular_value(&self, largest: f32) -> (f32, [f32; N]) {
        let mut v = start_vector::<N>(self.unknowns);
        let floor = (largest * 1.0e-9).max(f32::MIN_POSITIVE);
        let mut value = 0.0;
        for iteration in 0..ITERATIONS {
            let forward = self.forward_floored(&mut v, floor);
            let backward = self.backward_floored(&mut v, floor);
            let next = sqrt(forward) * sqrt(backward);
            if iteration >= LEAST && (next - value).abs() <= SETTLED * next {
                return (next, v);
            }
            value = next;
        }
        (value, v)
    }

    /// `v <- R v`.
    fn multiply(&self, v: &mut [f32; N]) {
        for i in 0..self.unknowns {
            v[i] = packed::dot(self.row(i), &v[i..]);
        }
    }

    /// `v <- R^T v`.
    fn multiply_transposed(&self, v: &mut [f32; N]) {
        let mut out = [0.0; N];
        for i in 0..self.unknowns {
            packed::subtract(&mut out[i..self.unknowns], -v[i], self.row(i));
        }
        *v = out;
    }

    /// `v <- R^-T v`, brought to length one; returns the inverse of the length it had.
    fn forward_floored(&self, v: &mut [f32; N], floor: f32) -> f32 {
        let mut shrunk = 1.0;
        for i in 0..self.unknowns {
            let row = self.row(i);
            let y = v[i] / row[0].max(floor);
            v[i] = y;
            packed::subtract(&mut v[i + 1..self.unknowns], y, &row[1..]);
            shrunk *= limit(v, i);
        }
        shrunk / normalise(&mut v[..self.unknowns])
    }

    /// `v <- R^-1 v`, brought to length one; returns the inverse of the length it had.
    fn backward_floored(&self, v: &mut [f32; N], floor: f32) -> f32 {
        let mut shrunk = 1.0;
        for i in (0..self.unknowns).rev() {
            let row = self.row(i);
            let sum = packed::dot(&row[1..], &v[i + 1..]);
            v[i] = (v[i] - sum) / row[0].max(floor);
            shrunk *= limit(v, i);
        }
        shrunk / normalise(&mut v[..self.unknowns])
    }
}

/// Shrinks the whole vector where entry `i` has grown near overflow; returns the factor.
fn limit(v: &mut [f32], i: usize) -> f32 {
    const SHRINK: f32 = 1.0e-12;
    if v[i].abs() < 1.0 / SHRINK {
        return 1.0;
    }
    v.iter_mut().for_each(|v| *v *= SHRINK);
    SHRINK
}

/// A vector with a part along every direction, for all practical factors.
fn start_vector<const N: usize>(unknowns: usize) -> [f32; N] {
    let mut v = [0.0; N];
    for (i, v) in v.iter_mut().enumerate().take(unknowns) {
        let spread = (i * 7 % 11) as f32;
        *v = if i % 3 == 1 {
            -1.0 - 0.05 * spread
        } else {
            1.0 + 0.03 * spread
        };
    }
    normalise(&mut v[..unknowns]);
    v
}

pub(super) fn norm(v: &[f32]) -> f32 {
    v.iter()
        .fold(0.0, |length, x| super::givens::hypot(length, *x))
}

/// Brings `v` to length one; returns the length it had.
fn normalise(v: &mut [f32]) -> f32 {
    let length = norm(v);
    if length > 0.0 {
        v.iter_mut().for_each(|x| *x /= length);
    }
    length
}
