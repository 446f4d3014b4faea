//! Fits of many sets of columns that share a large part: the part is eliminated once, and a set costs little more than what it
//! has besides (block elimination, Golub and Van Loan 2013, section 3.2.11).

use crate::design::gram::Gram;
use crate::design::training::Training;
use crate::inference::fit::{Fit, squares};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use normal_equations::symmetric::Symmetric;
use rayon::prelude::*;

/// Shared columns, eliminated from one training sum.
pub struct SchurElimination {
    columns: Vec<usize>,
    /// Inverse of the Cholesky factor of their precision.
    inverse: DMatrix<f64>,
    log_det: f64,
    /// `inverse` times a column's products with the shared ones, of those that were asked for; the target's last.
    reduced: Vec<Option<DVector<f64>>>,
    /// Products with the target and prior means.
    right: DVector<f64>,
}

impl SchurElimination {
    /// Cost: cube of the shared columns. None where they are dependent beyond what a prior mends.
    pub fn new(training: Training, centre: &[f64], columns: &[usize]) -> Option<Self> {
        let n = columns.len();
        let last = training.last();
        let mut precision = training.square(columns);
        for a in 0..n {
            precision[(a, a)] += 1.0;
        }
        let factor = Factor::new(precision)?;
        let log_det = factor.half_log_determinant();
        let inverse = factor.lower_inverse();
        let right = DVector::from_fn(n, |a, _| training.at(columns[a], last) + centre[columns[a]]);
        let mut reduced = vec![None; last + 1];
        reduced[last] = Some(&inverse * &right);
        Some(Self {
            columns: columns.to_vec(),
            inverse,
            log_det,
            reduced,
            right,
        })
    }

    fn reduce(&mut self, training: Training, more: &[usize]) {
        let unknown = |c: &usize| self.reduced[*c].is_none();
        let new: Vec<usize> = more.iter().copied().filter(unknown).collect();
        if new.is_empty() {
            return;
        }
        let part = &self.inverse * training.block(&self.columns, &new);
        for (k, c) in new.into_iter().enumerate() {
            self.reduced[c] = Some(part.column(k).into_owned());
        }
    }

    /// Fit of the shared columns and `more`, as [`crate::inference::fit::solve`] gives it for unit variance.
    pub fn fit(&mut self, training: Training, centre: &[f64], more: &[usize]) -> Option<Fit> {
        self.reduce(training, more);
        let last = training.last();
        let target = self.reduced[last].as_ref()?;
        let mut across = DMatrix::zeros(target.len(), more.len());
        for (mut column, c) in across.column_iter_mut().zip(more) {
            column.copy_from(self.reduced[*c].as_ref()?);
        }
        let mut normal = training.square(more);
        // A transposed product of its own is packed for the cache; one in place is a dot product an element.
        normal.gemm(-1.0, &across.transpose(), &across, 1.0);
        let right = DVector::from_fn(more.len(), |a, _| {
            training.at(more[a], last) + centre[more[a]]
        });
        for a in 0..more.len() {
            normal[(a, a)] += 1.0;
        }
        let factor = Factor::new(normal)?;
        let besides = factor.solve(&(&right - across.tr_mul(target)));
        let shared = self.inverse.tr_mul(&(target - &across * &besides));
        let columns: Vec<usize> = self.columns.iter().chain(more).copied().collect();
        let prior: f64 = columns.iter().map(|c| centre[*c].powi(2)).sum();
        let explained = self.right.dot(&shared) + right.dot(&besides);
        let log_det = self.log_det + factor.half_log_determinant();
        let coefficient = shared
            .iter()
            .chain(besides.iter())
            .copied()
            .collect::<Vec<f64>>();
        Some(Fit {
            columns,
            coefficient: coefficient.into(),
            log_evidence: 0.5 * (explained - prior - training.at(last, last)) - log_det,
            half_log_determinant: log_det,
        })
    }
}

/// The columns that sets are built upon, eliminated from every fold's training sum.
pub struct EliminatedBase {
    folds: Vec<Option<SchurElimination>>,
}

impl EliminatedBase {
    /// Eliminates `columns` from all training sums.
    pub fn new(gram: &Gram, columns: &[usize]) -> Self {
        let without = |f| SchurElimination::new(gram.training(Some(f)), &gram.centre, columns);
        Self {
            folds: (0..gram.fold.len()).into_par_iter().map(without).collect(),
        }
    }

    /// Fit and held-out squares of the shared columns and `more` by fold, and the carried noise's squares a row.
    pub fn scores(
        &mut self,
        gram: &Gram,
        errors_in_variables: &Symmetric,
        more: &[usize],
    ) -> Vec<Option<(Fit, f64, f64)>> {
        let score = |(f, shared): (usize, &mut Option<SchurElimination>)| {
            let fit = shared
                .as_mut()?
                .fit(gram.training(Some(f)), &gram.centre, more)?;
            let left = squares(&gram.fold[f], &fit.columns, &fit.coefficient);
            let noise = squares(errors_in_variables, &fit.columns, &fit.coefficient);
            Some((fit, left, noise))
        };
        self.folds.par_iter_mut().enumerate().map(score).collect()
    }
}
