//! Where things lie in a packed triangle: first the entering row, then the factor's rows, each with its right-hand side last.
//!
//! The loops that take the time are here and in `rotate`, on slices: one copy for triangles of every size, built for speed
//! with this package, where what is generic is built for size with the image that uses it.
//!
//! With `n` unknowns in use the entering row has `n + 1` numbers, row `i` of the factor `n + 1 - i`, its diagonal first.

use core::array::from_fn;
use core::ops::Range;

/// Numbers that a triangle of `n` unknowns is packed in, its right-hand side and a row that enters included.
#[must_use]
pub const fn packed_len(n: usize) -> usize {
    start(n, n)
}

/// Where row `row` of the factor starts; row `n` would be behind the end.
pub(super) const fn start(unknowns: usize, row: usize) -> usize {
    (unknowns + 1) * (row + 1) - row * row.saturating_sub(1) / 2
}

/// Row `row` of the factor: diagonal to right-hand side.
pub(super) const fn row(unknowns: usize, row: usize) -> Range<usize> {
    start(unknowns, row)..start(unknowns, row + 1)
}

/// `v <- v - y u` of as many numbers each, four in step so that no result is waited for.
#[inline(never)]
pub(super) fn subtract(v: &mut [f32], y: f32, u: &[f32]) {
    let ((v, v_rest), (u, u_rest)) = (v.as_chunks_mut::<4>(), u.as_chunks::<4>());
    for (v, u) in v.iter_mut().zip(u) {
        let (old, taken) = (*v, u.map(|u| y * u));
        *v = from_fn(|j| old[j] - taken[j]);
    }
    for (v, u) in v_rest.iter_mut().zip(u_rest) {
        *v -= y * u;
    }
}

/// `sum u v` of as many numbers each, four sums in step so that no result is waited for.
#[inline(never)]
pub(super) fn dot(u: &[f32], v: &[f32]) -> f32 {
    let ((u, u_rest), (v, v_rest)) = (u.as_chunks::<4>(), v.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (u, v) in u.iter().zip(v) {
        let products: [f32; 4] = from_fn(|j| u[j] * v[j]);
        (0..4).for_each(|j| sums[j] += products[j]);
    }
    for ((sum, u), v) in sums.iter_mut().zip(u_rest).zip(v_rest) {
        *sum += u * v;
    }
    sums.iter().sum()
}

/// Writes `row` in its columns' scales to `entries`, which are as many; returns its squared length.
#[inline(never)]
pub(super) fn scale(entries: &mut [f32], row: &[f32], scale: &[f32]) -> f32 {
    let mut squares = [0.0; 4];
    let (eights, entries) = entries.as_chunks_mut::<8>();
    let ((row_eights, row), (scale_eights, scale)) = (row.as_chunks::<8>(), scale.as_chunks::<8>());
    for ((entries, row), scale) in eights.iter_mut().zip(row_eights).zip(scale_eights) {
        for ((entries, row), scale) in fours(entries).iter_mut().zip(four(row)).zip(four(scale)) {
            *entries = scale_four(*row, *scale, &mut squares);
        }
    }
    let (fours, entries) = entries.as_chunks_mut::<4>();
    let ((row_fours, row), (scale_fours, scale)) = (row.as_chunks::<4>(), scale.as_chunks::<4>());
    for ((entries, row), scale) in fours.iter_mut().zip(row_fours).zip(scale_fours) {
        *entries = scale_four(*row, *scale, &mut squares);
    }
    for ((entry, x), scale) in entries.iter_mut().zip(row).zip(scale) {
        *entry = x * scale;
        squares[0] += *entry * *entry;
    }
    squares.iter().sum()
}

/// Four in step, so that no result is waited for.
#[inline(always)]
fn scale_four(row: [f32; 4], scale: [f32; 4], squares: &mut [f32; 4]) -> [f32; 4] {
    let scaled: [f32; 4] = from_fn(|k| row[k] * scale[k]);
    let square = scaled.map(|x| x * x);
    (0..4).for_each(|k| squares[k] += square[k]);
    scaled
}

#[inline(always)]
fn four(eight: &[f32; 8]) -> &[[f32; 4]] {
    eight.as_chunks().0
}

#[inline(always)]
fn fours(eight: &mut [f32; 8]) -> &mut [[f32; 4]] {
    eight.as_chunks_mut().0
}

#[cfg(test)]
mod tests {
    use super::{packed_len, row, start};

    #[test]
    fn rows_follow_each_other() {
        for n in 0..50 {
            assert_eq!(start(n, 0), n + 1);
            (0..n).for_each(|i| assert_eq!(row(n, i).len(), n + 1 - i));
            assert_eq!(packed_len(n), n * (n + 1) / 2 + 2 * n + 1);
        }
    }
}
