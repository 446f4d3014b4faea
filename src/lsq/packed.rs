//! Where things lie in a packed triangle: first the entering row, then the factor's rows, each with its right-hand side last.
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

/// `v <- v - y u`, four in step so that no result is waited for.
#[inline(always)]
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
