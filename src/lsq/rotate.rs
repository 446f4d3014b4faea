//! Rotating a row into the factor: scaled (square-root-free) Givens rotations, four rows of the factor a pass.
//!
//! Row `i` of the factor is kept as `r / sqrt(w)`, the entering row as `sqrt(g) a`, so that a rotation takes two
//! multiplications an entry instead of four, and no square root (Gentleman 1973, "Least squares computations by Givens
//! transformations without square roots"):
//!
//! ```text
//! t = a_i / r_ii,  x = g w t^2,  k = g w t
//! a_j <- a_j - t r_j,  r_j <- r_j + k a_j (the old one),  w <- w (1 + x),  g <- g / (1 + x)
//! ```
//!
//! This is used while `x <= 1`; a larger entry is turned in by an ordinary rotation, after which both weights are one. In
//! the long run all are of the first kind. Four rotations go along the row together: each entry of it is loaded and
//! stored once for four. The cost on the target is in the cost table.

use super::givens::Rotation;
use super::triangle::Triangle;
use crate::math::sqrt;

/// Rows of the factor a pass.
const BLOCK: usize = 4;
/// Product of pivot and its new square within which one division serves for all of a rotation's quotients.
const SAFE: core::ops::Range<f32> = 1.0e-30..1.0e30;
/// Row weights above this are brought back to one: far from overflow.
const HEAVY: f32 = 1.0e12;

/// One scaled rotation.
#[derive(Clone, Copy, Debug, Default)]
struct Shear {
    /// `t`.
    from_entry: f32,
    /// `k`.
    to_factor: f32,
    /// `1 + x`.
    growth: f32,
    /// `1 / (1 + x)`.
    shrink: f32,
}

impl Shear {
    /// `None` if the entry is too large for it, or the numbers too far from one.
    #[inline(always)]
    fn new(pivot: f32, weight: f32, entry: f32, entering_weight: f32) -> Option<Self> {
        let weights = entering_weight * weight;
        let square = pivot * pivot;
        let part = weights * entry * entry;
        let sum = square + part;
        let product = pivot * sum;
        if !SAFE.contains(&product) || part > square {
            return None;
        }
        let inverse = 1.0 / product;
        let per_pivot = sum * inverse;
        let from_entry = entry * per_pivot;
        Some(Self {
            from_entry,
            to_factor: weights * from_entry,
            growth: sum * per_pivot * per_pivot,
            shrink: square * pivot * inverse,
        })
    }

    #[inline(always)]
    fn apply(self, factor: &mut f32, entry: &mut f32) {
        let (f, e) = (*factor, *entry);
        *factor = f + self.to_factor * e;
        *entry = e - self.from_entry * f;
    }

    #[inline(always)]
    fn apply_in_step(self, factor: &mut [f32; BLOCK], entries: &mut [f32; BLOCK]) {
        let (f, e) = (*factor, *entries);
        let to_factor = e.map(|e| self.to_factor * e);
        let from_entry = f.map(|f| self.from_entry * f);
        for j in 0..BLOCK {
            factor[j] = f[j] + to_factor[j];
        }
        for j in 0..BLOCK {
            entries[j] = e[j] - from_entry[j];
        }
    }
}

/// Four rows of a packed triangle, cut after their common square corner: `rows[k]` starts at column `i + 4`.
struct Cut<'a> {
    rows: [&'a mut [f32]; BLOCK],
}

impl<'a> Cut<'a> {
    /// From the packed factor at the start of a row of `length` entries, at least [`BLOCK`] of them.
    fn new(factor: &'a mut [f32], length: usize) -> Option<Self> {
        let (first, factor) = factor.split_at_mut_checked(length)?;
        let (second, factor) = factor.split_at_mut_checked(length - 1)?;
        let (third, factor) = factor.split_at_mut_checked(length - 2)?;
        let fourth = factor.get_mut(..length - 3)?;
        let rows = [
            first.get_mut(BLOCK..)?,
            second.get_mut(BLOCK - 1..)?,
            third.get_mut(BLOCK - 2..)?,
            fourth.get_mut(BLOCK - 3..)?,
        ];
        Some(Self { rows })
    }

    /// Applies four rotations to all columns right of the corner, four columns in step so that no result is waited for.
    /// Per four columns: 20 loads, 32 multiplications, 32 additions, 20 stores.
    #[inline(always)]
    fn apply(self, shears: &[Shear; BLOCK], entries: &mut [f32]) {
        let [first, second, third, fourth] = self.rows;
        let (first, first_rest) = first.as_chunks_mut::<BLOCK>();
        let (second, second_rest) = second.as_chunks_mut::<BLOCK>();
        let (third, third_rest) = third.as_chunks_mut::<BLOCK>();
        let (fourth, fourth_rest) = fourth.as_chunks_mut::<BLOCK>();
        let (entries, entries_rest) = entries.as_chunks_mut::<BLOCK>();
        for ((((first, second), third), fourth), entries) in first
            .iter_mut()
            .zip(second)
            .zip(third)
            .zip(fourth)
            .zip(entries)
        {
            let mut e = *entries;
            shears[0].apply_in_step(first, &mut e);
            shears[1].apply_in_step(second, &mut e);
            shears[2].apply_in_step(third, &mut e);
            shears[3].apply_in_step(fourth, &mut e);
            *entries = e;
        }
        let rest = first_rest
            .iter_mut()
            .zip(second_rest)
            .zip(third_rest)
            .zip(fourth_rest)
            .zip(entries_rest);
        for ((((first, second), third), fourth), entry) in rest {
            shears[0].apply(first, entry);
            shears[1].apply(second, entry);
            shears[2].apply(third, entry);
            shears[3].apply(fourth, entry);
        }
    }
}

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Rotates the loaded row into the factor; returns what is left of its right-hand side.
    pub(super) fn rotate_in(&mut self, mut rest: f32) -> f32 {
        let mut entering_weight = 1.0;
        let (mut row, mut start) = (0, 0);
        while row < self.unknowns {
            let length = self.unknowns - row;
            if length >= BLOCK && self.rotate_block(row, start, &mut entering_weight, &mut rest) {
                start += BLOCK * length - BLOCK * (BLOCK - 1) / 2;
                row += BLOCK;
            } else {
                self.rotate_one(row, start, &mut entering_weight, &mut rest);
                start += length;
                row += 1;
            }
        }
        // A rotation at most doubles a weight: sixteen rows take it from HEAVY to 1e17 at most.
        if self.rows % 16 == 0 && self.row_weight.iter().any(|w| *w > HEAVY) {
            self.settle_rows();
        }
        rest * sqrt(entering_weight)
    }

    /// Four scaled rotations; false, and nothing is changed, if one of them cannot be.
    #[inline]
    fn rotate_block(
        &mut self,
        row: usize,
        start: usize,
        entering_weight: &mut f32,
        rest: &mut f32,
    ) -> bool {
        let length = self.unknowns - row;
        let Some(entries) = self.work.get_mut(row..self.unknowns) else {
            return false;
        };
        let Some((corner_entries, entries)) = entries.split_at_mut_checked(BLOCK) else {
            return false;
        };
        let (Some(weights), Some(rhs)) = (
            self.row_weight.get_mut(row..row + BLOCK),
            self.rhs.get_mut(row..row + BLOCK),
        ) else {
            return false;
        };
        let Some(factor) = self.factor.get_mut(start..) else {
            return false;
        };
        let mut shears = [Shear::default(); BLOCK];
        let (mut e, mut weight, mut left) = ([0.0; BLOCK], *entering_weight, *rest);
        e.copy_from_slice(corner_entries);
        // Corner, on copies: rows k of it are columns k.. of the block.
        let mut corner = [[0.0f32; BLOCK]; BLOCK];
        let mut at = 0;
        for k in 0..BLOCK {
            let Some(from) = factor.get(at..at + BLOCK - k) else {
                return false;
            };
            corner[k][k..].copy_from_slice(from);
            at += length - k;
        }
        let mut z = [0.0; BLOCK];
        z.copy_from_slice(rhs);
        for k in 0..BLOCK {
            let Some(shear) = Shear::new(corner[k][k], weights[k], e[k], weight) else {
                return false;
            };
            for j in k..BLOCK {
                shear.apply(&mut corner[k][j], &mut e[j]);
            }
            shear.apply(&mut z[k], &mut left);
            weight *= shear.shrink;
            shears[k] = shear;
        }
        rhs.copy_from_slice(&z);
        let mut at = 0;
        for k in 0..BLOCK {
            weights[k] *= shears[k].growth;
            if let Some(to) = factor.get_mut(at..at + BLOCK - k) {
                to.copy_from_slice(&corner[k][k..]);
            }
            at += length - k;
        }
        if let Some(cut) = Cut::new(factor, length) {
            cut.apply(&shears, entries);
        }
        (*entering_weight, *rest) = (weight, left);
        true
    }

    /// One ordinary rotation, after which the row's and the entering row's weights are one.
    fn rotate_one(&mut self, row: usize, start: usize, entering_weight: &mut f32, rest: &mut f32) {
        let length = self.unknowns - row;
        let Some(entries) = self.work.get_mut(row..self.unknowns) else {
            return;
        };
        if entries[0] == 0.0 {
            return;
        }
        let (entry_scale, row_scale) = (sqrt(*entering_weight), 1.0 / sqrt(self.row_weight[row]));
        let factor = &mut self.factor[start..start + length];
        for (factor, entry) in factor.iter_mut().zip(&mut *entries) {
            *factor *= row_scale;
            *entry *= entry_scale;
        }
        let z = &mut self.rhs[row];
        (*z, *rest) = (*z * row_scale, *rest * entry_scale);
        (self.row_weight[row], *entering_weight) = (1.0, 1.0);
        let (rotation, radius) = Rotation::new(factor[0], entries[0]);
        factor[0] = radius;
        rotation.turn_all(&mut factor[1..], &mut entries[1..]);
        rotation.turn(z, rest);
    }

    /// Brings all row weights to one: the factor is then plain.
    #[cold]
    pub(super) fn settle_rows(&mut self) {
        let mut start = 0;
        for row in 0..self.unknowns {
            let length = self.unknowns - row;
            let scale = 1.0 / sqrt(self.row_weight[row]);
            if self.row_weight[row] != 1.0 {
                self.factor[start..start + length]
                    .iter_mut()
                    .for_each(|f| *f *= scale);
                self.rhs[row] *= scale;
                self.row_weight[row] = 1.0;
            }
            start += length;
        }
    }
}
