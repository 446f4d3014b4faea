//! The upper-triangular factor `R = sqrt(D) U` with right-hand side, residual and count.
//!
//! Each column and the right-hand side carry a scale, a power of two set by the first value seen and lowered when a much
//! larger one comes: problems in metres, micrometres or at the ends of f32 give the same bits in the factor.

use super::givens::hypot;
use super::packed::{self, packed_len};
use super::rotate::{LEAST_PIVOT, rotate};
use crate::math::sqrt;

/// Scaled values above this lower their column's scale: far from overflow even after 2^40 rows. Derived from f32's largest
/// number, 3e38: 1e12 · 2^40 is 1e24.
const LARGE: f32 = 1.0e12;

/// Why a row was not entered. The factor is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RowError {
    /// The row's length differs from the number of unknowns in use.
    Length {
        /// Length given.
        given: usize,
        /// Unknowns in use.
        unknowns: usize,
    },
    /// An entry is infinite or not a number.
    Entry {
        /// Its column.
        column: usize,
    },
    /// The right-hand side is infinite or not a number.
    RightHandSide,
}

impl core::fmt::Display for RowError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { given, unknowns } => {
                write!(f, "row has {given} entries, {unknowns} unknowns are in use")
            }
            Self::Entry { column } => write!(f, "row's entry {column} is not a finite number"),
            Self::RightHandSide => write!(f, "row's right-hand side is not a finite number"),
        }
    }
}

impl core::error::Error for RowError {}

/// Triangular factor of up to `N` unknowns, packed by rows; `P = packed_len(N)`.
#[derive(Clone, Debug)]
pub struct Triangle<const N: usize, const P: usize> {
    pub(super) unknowns: usize,
    /// The entering row, then the factor's ([`packed`]): a row is `d`, then `U`'s right of the diagonal, then the
    /// right-hand side over `sqrt(d)`.
    pub(super) packed: [f32; P],
    pub(super) scale: [f32; N],
    all_scaled: bool,
    pub(super) rhs_scale: f32,
    /// Its inverse, exactly; zero with it.
    pub(super) rhs_unit: f32,
    /// Sum of squared residuals, scaled.
    pub(super) residual_square: f32,
    pub(super) rows: u32,
    pub(super) weight: f32,
}

impl<const N: usize, const P: usize> Default for Triangle<N, P> {
    fn default() -> Self {
        Self::new(N)
    }
}

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Empty factor with `unknowns` (at most `N`; more are cut to `N`) in use.
    #[must_use]
    pub const fn new(unknowns: usize) -> Self {
        const { assert!(P == packed_len(N)) };
        Self {
            unknowns: if unknowns < N { unknowns } else { N },
            packed: [0.0; P],
            scale: [0.0; N],
            all_scaled: false,
            rhs_scale: 0.0,
            rhs_unit: 0.0,
            residual_square: 0.0,
            rows: 0,
            weight: 0.0,
        }
    }

    /// Forgets everything, in place, and sets the number of unknowns in use (at most `N`).
    pub fn reset(&mut self, unknowns: usize) {
        self.unknowns = unknowns.min(N);
        self.packed.fill(0.0);
        self.scale.fill(0.0);
        self.all_scaled = false;
        self.rhs_scale = 0.0;
        self.rhs_unit = 0.0;
        self.residual_square = 0.0;
        self.rows = 0;
        self.weight = 0.0;
    }

    /// Unknowns in use.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Rows entered since the last reset.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Rows entered, each weighted by what has been forgotten of it since.
    #[must_use]
    pub fn effective_rows(&self) -> f32 {
        self.weight
    }

    /// Square root of the sum of squared residuals of the least-squares solution, in the right-hand side's unit.
    #[must_use]
    pub fn residual_norm(&self) -> f32 {
        self.residual_norm_with(0.0)
    }

    /// Entry of the factor in the units of the rows as entered; zero below the diagonal and outside the unknowns in use.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f32 {
        if row > column || column >= self.unknowns || self.scale[column] == 0.0 {
            return 0.0;
        }
        let factor = self.row(row);
        let root = sqrt(factor[0]);
        let scaled = if row == column {
            root
        } else {
            root * factor[column - row]
        };
        scaled / self.scale[column]
    }

    /// Right-hand side of a row of the factor, in the unit of the right-hand sides as entered; zero outside the unknowns in use.
    #[must_use]
    pub fn right_hand_side(&self, row: usize) -> f32 {
        if row >= self.unknowns {
            return 0.0;
        }
        let factor = self.row(row);
        sqrt(factor[0]) * factor[factor.len() - 1] * self.rhs_unit
    }

    /// Enters the equation `row * x = rhs`. Weight an equation by multiplying both sides by 1 / standard deviation.
    ///
    /// Returns the part of `rhs` that the new row adds to the residual: its innovation divided by
    /// `sqrt(1 + leverage)`, up to sign.
    ///
    /// # Errors
    /// [`RowError`], and nothing is changed.
    pub fn enter(&mut self, row: &[f32], rhs: f32) -> Result<f32, RowError> {
        if !self.load_quickly(row, rhs) {
            self.check(row, rhs)?;
            self.rescale(row);
            self.rescale_rhs(rhs);
            // Right sides that were all zero have no scale yet.
            self.all_scaled &= self.rhs_scale != 0.0;
            self.load(row, rhs);
        }
        let rest = rotate(&mut self.packed, self.unknowns, 0);
        self.residual_square += rest * rest;
        self.rows = self.rows.saturating_add(1);
        self.weight += 1.0;
        Ok(rest * self.rhs_unit)
    }

    /// Lets all rows so far count `factor` (0 to 1) times as much: an exponential window of `1 / (1 - factor)` rows if
    /// called before each. Values outside 0 to 1 are ignored.
    pub fn forget(&mut self, factor: f32) {
        if !(0.0..=1.0).contains(&factor) {
            return;
        }
        for row in 0..self.unknowns {
            let pivot = &mut self.row_mut(row)[0];
            *pivot *= factor;
            if *pivot < LEAST_PIVOT {
                *pivot = 0.0;
            }
        }
        self.residual_square *= factor;
        self.weight *= factor;
    }

    /// Row of the factor: `d`, the rest of `U`'s row, the right-hand side.
    #[inline]
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.packed[packed::row(self.unknowns, row)]
    }

    #[inline]
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.packed[packed::row(self.unknowns, row)]
    }

    /// Solves `U^T y = v` in place in scaled columns: `R^-T v = y / sqrt(D)`. False if a pivot that is needed has vanished.
    pub(super) fn forward(&self, v: &mut [f32]) -> bool {
        let (mut rest, mut factor) = (v, &self.packed[self.unknowns + 1..]);
        for length in (1..=self.unknowns).rev() {
            let ((y, v), (row, next)) =
                (rest[..length].split_at_mut(1), factor.split_at(length + 1));
            (rest, factor) = (v, next);
            if y[0] == 0.0 {
                continue;
            }
            if row[0] == 0.0 || !y[0].is_finite() {
                return false;
            }
            packed::subtract(rest, y[0], &row[1..length]);
        }
        true
    }

    /// Solves `U x = v` in place in scaled columns.
    pub(super) fn backward(&self, v: &mut [f32]) {
        for i in (0..self.unknowns).rev() {
            let (head, tail) = v[i..self.unknowns].split_at_mut(1);
            head[0] -= packed::dot(&self.row(i)[1..=tail.len()], tail);
        }
    }

    /// The residual with a further, scaled part in it.
    pub(super) fn residual_norm_with(&self, scaled: f32) -> f32 {
        hypot(sqrt(self.residual_square), scaled) * self.rhs_unit
    }

    pub(super) fn check(&self, row: &[f32], rhs: f32) -> Result<(), RowError> {
        if row.len() != self.unknowns {
            return Err(RowError::Length {
                given: row.len(),
                unknowns: self.unknowns,
            });
        }
        if let Some(column) = row.iter().position(|x| !x.is_finite()) {
            return Err(RowError::Entry { column });
        }
        if rhs.is_finite() {
            Ok(())
        } else {
            Err(RowError::RightHandSide)
        }
    }

    /// Makes the row the entering one, in the columns' scales; false if these are not all set or do not suit, or a number is
    /// not finite.
    fn load_quickly(&mut self, row: &[f32], rhs: f32) -> bool {
        self.all_scaled && row.len() == self.unknowns && self.load(row, rhs) < LARGE * LARGE
    }

    /// Makes the row the entering one, in the columns' scales; returns its squared length.
    #[inline(always)]
    fn load(&mut self, row: &[f32], rhs: f32) -> f32 {
        let n = self.unknowns;
        let square = packed::scale(&mut self.packed[..n], row, &self.scale[..n]);
        let rhs = rhs * self.rhs_scale;
        self.packed[n] = rhs;
        square + rhs * rhs
    }

    /// Brings the columns' scales to the row where it is out of their reach.
    #[cold]
    fn rescale(&mut self, row: &[f32]) {
        for (column, x) in row.iter().enumerate() {
            let old = self.scale[column];
            if *x == 0.0 || (old != 0.0 && (x * old).abs() <= LARGE) {
                continue;
            }
            let new = power_of_two_scale(*x);
            self.scale[column] = new;
            if old != 0.0 {
                self.rescale_column(column, old, new);
            }
        }
        self.all_scaled = !self.scale[..self.unknowns].contains(&0.0);
    }

    /// Brings a column of the factor, which has had numbers in it, to another scale. Where its pivot vanishes by that, what
    /// its row says of the other unknowns is entered again.
    fn rescale_column(&mut self, column: usize, old: f32, new: f32) {
        for i in 0..column {
            let u = &mut self.row_mut(i)[column - i];
            *u = rescaled(*u, old, new);
        }
        let row = self.row_mut(column);
        let pivot = rescaled(sqrt(row[0]), old, new);
        if pivot * pivot >= LEAST_PIVOT {
            row[1..]
                .iter_mut()
                .for_each(|u| *u = rescaled(*u, new, old));
            row[0] = pivot * pivot;
            return;
        }
        let root = sqrt(row[0]);
        let (entering, factor) = self.packed.split_at_mut(self.unknowns + 1);
        let row = packed::row(self.unknowns, column);
        let row = &mut factor[row.start - entering.len()..row.end - entering.len()];
        entering[..=column].fill(0.0);
        for (entry, u) in entering[column + 1..].iter_mut().zip(&row[1..]) {
            *entry = root * u;
        }
        row.fill(0.0);
        let rest = rotate(&mut self.packed, self.unknowns, column + 1);
        self.residual_square += rest * rest;
    }

    /// Brings the right-hand side's scale to a value that is out of its reach.
    #[cold]
    fn rescale_rhs(&mut self, rhs: f32) {
        let old = self.rhs_scale;
        if rhs == 0.0 || (old != 0.0 && (rhs * old).abs() <= LARGE) {
            return;
        }
        let new = power_of_two_scale(rhs);
        for i in 0..self.unknowns {
            if let Some(z) = self.row_mut(i).last_mut() {
                *z = rescaled(*z, old, new);
            }
        }
        self.residual_square = rescaled(rescaled(self.residual_square, old, new), old, new);
        self.rhs_scale = new;
        self.rhs_unit = 1.0 / new;
    }
}

/// Power of two that brings `x` (not zero) to between 1 and 2, as far as f32 has such a power.
fn power_of_two_scale(x: f32) -> f32 {
    let exponent = (x.to_bits() >> 23) & 0xff;
    f32::from_bits((254 - exponent.clamp(1, 253)) << 23)
}

/// A scaled value under another scale, in two exact steps so that their quotient need not be a float.
fn rescaled(value: f32, old: f32, new: f32) -> f32 {
    if value == 0.0 || old == 0.0 {
        0.0
    } else {
        value / old * new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Right sides of zero, however many come first, give no scale that later ones are lost by.
    #[test]
    fn right_sides_that_begin_with_zero_are_not_all_zero() {
        let mut triangle: Triangle<2, { packed_len(2) }> = Triangle::new(2);
        for (row, rhs) in [
            ([1.0, 1.0], 0.0),
            ([2.0, 1.0], 0.0),
            ([1.0, -1.0], 4.0),
            ([1.0, 2.0], 1.0),
        ] {
            triangle.enter(&row, rhs).unwrap();
        }
        // A^T A = [7 4; 4 7] and A^T b = [5; -2]: x = (5 * 7 + 2 * 4) / 33.
        let found = triangle.predict(&[1.0, 0.0]).unwrap().value;
        assert!((found - 43.0 / 33.0).abs() < 1.0e-6, "{found}");
    }
}
