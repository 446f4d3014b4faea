//! The upper-triangular factor `R` with right-hand side `z`, residual and count.
//!
//! Each column and the right-hand side carry a scale, a power of two set by the first value seen and lowered when a much
//! larger one comes: problems in metres, micrometres or at the ends of f32 give the same bits in the factor.

use super::givens::hypot;
use super::packed_len;

/// Scaled values above this lower their column's scale: far from overflow even after 2^40 rows.
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
    pub(super) factor: [f32; P],
    pub(super) rhs: [f32; N],
    pub(super) scale: [f32; N],
    all_scaled: bool,
    pub(super) rhs_scale: f32,
    /// Row `i` of factor and right-hand side is to be divided by the root of this.
    pub(super) row_weight: [f32; N],
    pub(super) work: [f32; N],
    pub(super) residual_norm: f32,
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
            factor: [0.0; P],
            rhs: [0.0; N],
            scale: [0.0; N],
            all_scaled: false,
            rhs_scale: 0.0,
            row_weight: [1.0; N],
            work: [0.0; N],
            residual_norm: 0.0,
            rows: 0,
            weight: 0.0,
        }
    }

    /// Forgets everything, in place, and sets the number of unknowns in use (at most `N`).
    pub fn reset(&mut self, unknowns: usize) {
        self.unknowns = unknowns.min(N);
        self.factor.fill(0.0);
        self.rhs.fill(0.0);
        self.scale.fill(0.0);
        self.all_scaled = false;
        self.rhs_scale = 0.0;
        self.row_weight.fill(1.0);
        self.residual_norm = 0.0;
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
        if self.rhs_scale == 0.0 {
            0.0
        } else {
            self.residual_norm / self.rhs_scale
        }
    }

    /// Entry of the factor in the units of the rows as entered; zero below the diagonal and outside the unknowns in use.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f32 {
        if row > column || column >= self.unknowns || self.scale[column] == 0.0 {
            return 0.0;
        }
        let scaled =
            self.factor[self.start(row) + column - row] / crate::math::sqrt(self.row_weight[row]);
        scaled / self.scale[column]
    }

    /// Enters the equation `row * x = rhs`. Weight an equation by multiplying both sides by 1 / standard deviation.
    ///
    /// Returns the part of `rhs` that the new row adds to the residual: its innovation divided by
    /// `sqrt(1 + leverage)`, up to sign.
    ///
    /// # Errors
    /// [`RowError`], and nothing is changed.
    pub fn enter(&mut self, row: &[f32], rhs: f32) -> Result<f32, RowError> {
        if !self.load_quickly(row) || !rhs.is_finite() {
            self.check(row, rhs)?;
            self.load(row);
        }
        let rest = self.load_rhs(rhs);
        let rest = self.rotate_in(rest);
        self.residual_norm = hypot(self.residual_norm, rest);
        self.rows = self.rows.saturating_add(1);
        self.weight += 1.0;
        Ok(if self.rhs_scale == 0.0 {
            0.0
        } else {
            rest / self.rhs_scale
        })
    }

    /// Lets all rows so far count `factor` (0 to 1) times as much: an exponential window of `1 / (1 - factor)` rows if
    /// called before each. Values outside 0 to 1 are ignored.
    pub fn forget(&mut self, factor: f32) {
        if !(0.0..=1.0).contains(&factor) {
            return;
        }
        let root = crate::math::sqrt(factor);
        for value in self.factor.iter_mut().chain(&mut self.rhs) {
            *value *= root;
        }
        self.residual_norm *= root;
        self.weight *= factor;
    }

    /// Solves `r^T u = v` in place in scaled columns, `r` the factor without its row weights `w`: with `R = r / sqrt(w)` it is
    /// `R^-T v = sqrt(w) u`. False if a diagonal entry that is needed has vanished.
    pub(super) fn forward(&self, v: &mut [f32]) -> bool {
        let mut start = 0;
        for i in 0..self.unknowns {
            let row = &self.factor[start..start + self.unknowns - i];
            start += row.len();
            let rest = &mut v[i..self.unknowns];
            if rest[0] == 0.0 {
                continue;
            }
            let y = rest[0] / row[0];
            if !y.is_finite() {
                return false;
            }
            rest[0] = y;
            for (rest, row) in rest[1..].iter_mut().zip(&row[1..]) {
                *rest -= y * row;
            }
        }
        true
    }

    /// Solves `r x = v` in place in scaled columns: `R x = v / sqrt(w)`. A vanished diagonal entry gives infinities.
    pub(super) fn backward(&self, v: &mut [f32]) {
        let mut start = packed_len(self.unknowns);
        for i in (0..self.unknowns).rev() {
            start -= self.unknowns - i;
            let row = &self.factor[start..start + self.unknowns - i];
            let (head, tail) = v[i..self.unknowns].split_at_mut(1);
            let sum: f32 = row[1..].iter().zip(tail).map(|(r, x)| r * *x).sum();
            head[0] = (head[0] - sum) / row[0];
        }
    }

    /// Enters a row given in scaled columns with a scaled right-hand side; neither residual nor count is touched.
    /// Returns what is left of the right-hand side; row weights are one afterwards.
    pub(super) fn enter_scaled(&mut self, row: &[f32], rhs: f32) -> f32 {
        self.work[..self.unknowns].copy_from_slice(&row[..self.unknowns]);
        let left = self.rotate_in(rhs);
        self.settle_rows();
        left
    }

    /// The residual with a further, scaled part in it.
    pub(super) fn residual_norm_with(&self, scaled: f32) -> f32 {
        if self.rhs_scale == 0.0 {
            0.0
        } else {
            hypot(self.residual_norm, scaled) / self.rhs_scale
        }
    }

    /// Where a row of the packed factor starts.
    pub(super) fn start(&self, row: usize) -> usize {
        row * (2 * self.unknowns + 1 - row) / 2
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

    /// Brings the row to the columns' scales; false if these are not all set, or do not suit, or an entry is not finite.
    #[inline]
    fn load_quickly(&mut self, row: &[f32]) -> bool {
        if row.len() != self.unknowns || !self.all_scaled {
            return false;
        }
        let mut squares = 0.0;
        for ((work, scale), x) in self.work.iter_mut().zip(&self.scale).zip(row) {
            *work = x * scale;
            squares += *work * *work;
        }
        squares < LARGE * LARGE
    }

    /// Brings the row to the columns' scales, and these to the row where it is out of their reach.
    fn load(&mut self, row: &[f32]) {
        let mut largest = 0.0f32;
        for ((work, scale), x) in self.work.iter_mut().zip(&self.scale).zip(row) {
            *work = x * scale;
            largest = if *scale == 0.0 && *x != 0.0 {
                f32::INFINITY
            } else {
                largest.max(work.abs())
            };
        }
        if largest > LARGE {
            self.rescale(row);
        }
        self.all_scaled = !self.scale[..self.unknowns].contains(&0.0);
    }

    #[cold]
    fn rescale(&mut self, row: &[f32]) {
        for (column, x) in row.iter().enumerate() {
            let old = self.scale[column];
            if *x == 0.0 || (old != 0.0 && (x * old).abs() <= LARGE) {
                continue;
            }
            let new = power_of_two_scale(*x);
            for i in 0..=column {
                let at = self.start(i) + column - i;
                self.factor[at] = rescaled(self.factor[at], old, new);
            }
            self.scale[column] = new;
            self.work[column] = x * new;
        }
    }

    fn load_rhs(&mut self, rhs: f32) -> f32 {
        let old = self.rhs_scale;
        if rhs != 0.0 && (old == 0.0 || (rhs * old).abs() > LARGE) {
            let new = power_of_two_scale(rhs);
            for z in &mut self.rhs {
                *z = rescaled(*z, old, new);
            }
            self.residual_norm = rescaled(self.residual_norm, old, new);
            self.rhs_scale = new;
        }
        rhs * self.rhs_scale
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
