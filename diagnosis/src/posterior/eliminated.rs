//! The coefficients of a set at given sizes and noise, eliminated: the solutions of their normal equations.
//!
//! The largest block is eliminated first. In its own axes (`own_axes.rs`) its products are a diagonal, so that it costs no more than the
//! products with the others.

use super::reduced::Reduced;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::ops::Range;

/// The precision of a set's coefficients, factored. Rows and columns are in the order of the set.
#[derive(Clone, Debug)]
pub struct Eliminated {
    /// Place of the block that is eliminated first, among the set's columns; empty where no block is in its own axes.
    first: Range<usize>,
    /// Root of the variance of each of its coefficients by itself.
    root: DVector<f64>,
    /// Products of that block with the others, each row times its root, `[first, others]`.
    mixed: DMatrix<f64>,
    /// Inverse of the Cholesky factor of what is then left of the others' precision.
    others: DMatrix<f64>,
    /// Half the logarithm of the determinant of the precision.
    pub half_log_determinant: f64,
}

impl Eliminated {
    /// Of a set with the logarithm of each block's variance over the stated one, at a variance of the noise. None where the precision is
    /// not positive. Cost: the columns of the largest block times the square of the others', and their cube.
    pub fn new(
        reduced: &Reduced,
        set: &[usize],
        log_variances: &[f64],
        noise: f64,
    ) -> Option<Self> {
        let list = reduced.columns(set);
        let prior: Vec<f64> = set
            .iter()
            .zip(log_variances)
            .flat_map(|(b, v)| reduced.blocks[*b].clone().map(move |_| (-v).exp()))
            .collect();
        let first = first(reduced, set);
        let of_first = |k: usize| {
            (reduced.normal[(list[k], list[k])] / noise + prior[k])
                .sqrt()
                .recip()
        };
        let root = DVector::from_iterator(first.len(), first.clone().map(of_first));
        let rest: Vec<usize> = (0..list.len()).filter(|k| !first.contains(k)).collect();
        let of_rest: Vec<usize> = rest.iter().map(|k| list[*k]).collect();
        let mut mixed = reduced.across(&list[first.clone()], &of_rest) / noise;
        for mut column in mixed.column_iter_mut() {
            column.component_mul_assign(&root);
        }
        let mut left = reduced.square(&of_rest) / noise;
        for (k, place) in rest.iter().enumerate() {
            left[(k, k)] += prior[*place];
        }
        left.gemm(-1.0, &mixed.transpose(), &mixed, 1.0);
        let factor = Factor::new(left)?;
        let half_log_determinant =
            factor.half_log_determinant() - root.iter().map(|r| r.ln()).sum::<f64>();
        half_log_determinant.is_finite().then(|| Self {
            first,
            root,
            mixed,
            others: factor.lower_inverse(),
            half_log_determinant,
        })
    }

    /// The others' rows of a matrix with a row for each coefficient, and the first block's times their roots.
    fn split(&self, rows: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let Range { start, end } = self.first;
        let mut own = rows.rows(start, end - start).into_owned();
        for mut column in own.column_iter_mut() {
            column.component_mul_assign(&self.root);
        }
        (rows.clone().remove_rows(start, end - start), own)
    }

    /// `[coefficients, columns]` times the inverse of a factor of the precision: its squares are what the coefficients take of the columns'.
    pub fn half(&self, across: &DMatrix<f64>) -> DMatrix<f64> {
        let (mut rest, own) = self.split(across);
        rest.gemm(-1.0, &self.mixed.transpose(), &own, 1.0);
        let (n, r) = (own.nrows(), rest.nrows());
        let rest = &self.others * rest;
        let mut out = own.resize_vertically(n + r, 0.0);
        out.rows_mut(n, r).copy_from(&rest);
        out
    }

    /// Solution for a right side.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let (mut rest, mut own) = self.split(&DMatrix::from_column_slice(
            right.len(),
            1,
            right.as_slice(),
        ));
        rest.gemm(-1.0, &self.mixed.transpose(), &own, 1.0);
        let rest = self.others.tr_mul(&(&self.others * rest));
        own.gemm(-1.0, &self.mixed, &rest, 1.0);
        own.column_mut(0).component_mul_assign(&self.root);
        let start = self.first.start;
        let mut out = rest
            .column(0)
            .into_owned()
            .insert_rows(start, own.nrows(), 0.0);
        out.rows_mut(start, own.nrows()).copy_from(&own);
        out
    }

    /// Variance of each coefficient. Cost: as that of [`Self::new`].
    pub fn variances(&self) -> DVector<f64> {
        let squares = |m: &DMatrix<f64>| {
            DVector::from_iterator(m.ncols(), m.column_iter().map(|c| c.norm_squared()))
        };
        let n = self.mixed.nrows();
        let through = &self.others * self.mixed.transpose();
        let mut own = squares(&through).add_scalar(1.0);
        own.component_mul_assign(&self.root.map(|r| r * r));
        let start = self.first.start;
        let mut out = squares(&self.others).insert_rows(start, n, 0.0);
        out.rows_mut(start, n).copy_from(&own);
        out
    }
}

/// Place of the largest block that is in its own axes, among a set's columns.
fn first(reduced: &Reduced, set: &[usize]) -> Range<usize> {
    if !reduced.in_own_axes {
        return 0..0;
    }
    let mut at = 0;
    let places = set.iter().map(|b| {
        let start = at;
        at += reduced.blocks[*b].len();
        start..at
    });
    places.max_by_key(Range::len).unwrap_or(0..0)
}
