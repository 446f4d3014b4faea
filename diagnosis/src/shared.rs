//! Fits of many sets of columns that share a large part: the part is eliminated once, and a set costs little more than what it
//! has besides (block elimination, Golub and Van Loan 2013, section 3.2.11).

use crate::gram::{Fit, Gram, Training};
use nalgebra::{DMatrix, DVector};

/// The products among the shared columns, as one piece of memory.
fn block(of: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |a, b| of[(rows[a], columns[b])])
}

/// Shared columns, eliminated from one training sum.
pub struct Shared {
    columns: Vec<usize>,
    /// Inverse of the Cholesky factor of their precision.
    inverse: DMatrix<f64>,
    log_det: f64,
    /// `inverse` times each column's products with the shared ones, those of `known`; the target's last.
    reduced: DMatrix<f64>,
    known: Vec<bool>,
    /// Products with the target and prior means.
    right: DVector<f64>,
    /// Products among them in the fold that is left out.
    test: DMatrix<f64>,
}

impl Shared {
    /// Cost: cube of the shared columns. None where they are dependent beyond what a prior mends.
    pub fn new(training: Training, centre: &[f64], columns: &[usize]) -> Option<Self> {
        let n = columns.len();
        let last = training.last();
        let mut precision = training.block(columns, columns);
        for a in 0..n {
            precision[(a, a)] += 1.0;
        }
        let lower = precision.cholesky()?.unpack();
        let log_det = lower.diagonal().iter().map(|d| d.ln()).sum();
        let inverse = lower.solve_lower_triangular(&DMatrix::identity(n, n))?;
        let right = DVector::from_fn(n, |a, _| training.at(columns[a], last) + centre[columns[a]]);
        let mut reduced = DMatrix::zeros(n, last + 1);
        reduced.set_column(last, &(&inverse * &right));
        let mut known = vec![false; last + 1];
        known[last] = true;
        Some(Self {
            columns: columns.to_vec(),
            test: block(training.test, columns, columns),
            inverse,
            log_det,
            reduced,
            known,
            right,
        })
    }

    fn reduce(&mut self, training: Training, more: &[usize]) {
        let new: Vec<usize> = more.iter().copied().filter(|c| !self.known[*c]).collect();
        if new.is_empty() {
            return;
        }
        let part = &self.inverse * training.block(&self.columns, &new);
        for (k, c) in new.into_iter().enumerate() {
            self.reduced.set_column(c, &part.column(k));
            self.known[c] = true;
        }
    }

    /// Fit of the shared columns and `more`, as [`crate::gram::solve`] gives it for unit variance.
    pub fn fit(&mut self, training: Training, centre: &[f64], more: &[usize]) -> Option<Fit> {
        self.reduce(training, more);
        let last = training.last();
        let across = self.reduced.select_columns(more);
        let target = self.reduced.column(last);
        let mut normal = training.block(more, more) - across.tr_mul(&across);
        let right = DVector::from_fn(more.len(), |a, _| {
            training.at(more[a], last) + centre[more[a]]
        });
        for a in 0..more.len() {
            normal[(a, a)] += 1.0;
        }
        let factor = normal.cholesky()?;
        let besides = factor.solve(&(&right - across.tr_mul(&target)));
        let shared = self.inverse.tr_mul(&(target - &across * &besides));
        let columns: Vec<usize> = self.columns.iter().chain(more).copied().collect();
        let prior: f64 = columns.iter().map(|c| centre[*c].powi(2)).sum();
        let explained = self.right.dot(&shared) + right.dot(&besides);
        let diagonal = factor.l_dirty().diagonal();
        let log_det = self.log_det + diagonal.iter().map(|d| d.ln()).sum::<f64>();
        let amount = shared
            .iter()
            .chain(besides.iter())
            .copied()
            .collect::<Vec<f64>>();
        Some(Fit {
            columns,
            amount: amount.into(),
            log_evidence: 0.5 * (explained - prior - training.at(last, last)) - log_det,
        })
    }

    /// [`crate::gram::squares`] of a fit of [`Self::fit`] on the fold that was left out.
    pub fn squares(&self, test: &DMatrix<f64>, fit: &Fit) -> f64 {
        squares(test, &self.test, fit)
    }
}

/// Squared residual of a fit whose first columns' products are at hand as `among`.
pub fn squares(test: &DMatrix<f64>, among: &DMatrix<f64>, fit: &Fit) -> f64 {
    let last = test.nrows() - 1;
    let n = among.nrows();
    let (shared, besides) = (fit.amount.rows(0, n), fit.amount.rows_range(n..));
    let mut sum = test[(last, last)] + shared.dot(&(among * shared));
    for (a, c) in fit.columns[..n].iter().enumerate() {
        sum -= 2.0 * test[(*c, last)] * shared[a];
    }
    for (b, c) in fit.columns[n..].iter().enumerate() {
        let column = test.column(*c);
        let mut inner = -2.0 * column[last];
        for (a, d) in fit.columns[..n].iter().enumerate() {
            inner += 2.0 * column[*d] * shared[a];
        }
        for (a, d) in fit.columns[n..].iter().enumerate() {
            inner += column[*d] * besides[a];
        }
        sum += inner * besides[b];
    }
    sum
}

/// The columns that sets are built upon, eliminated from every fold's training sum.
pub struct Base {
    folds: Vec<Option<Shared>>,
    /// Carried noise among them.
    carried: DMatrix<f64>,
}

impl Base {
    /// Eliminates `columns` from all training sums.
    pub fn new(gram: &Gram, carried: &DMatrix<f64>, columns: &[usize]) -> Self {
        let folds = (0..gram.fold.len()).map(|f| gram.trained_without(f));
        Self {
            folds: folds
                .map(|training| Shared::new(training, &gram.centre, columns))
                .collect(),
            carried: block(carried, columns, columns),
        }
    }

    /// Fit and held-out squares of the shared columns and `more` in a fold, and the carried noise's squares a row.
    pub fn score(
        &mut self,
        gram: &Gram,
        carried: &DMatrix<f64>,
        fold: usize,
        more: &[usize],
    ) -> Option<(Fit, f64, f64)> {
        let shared = self.folds[fold].as_mut()?;
        let fit = shared.fit(gram.trained_without(fold), &gram.centre, more)?;
        let left = shared.squares(&gram.fold[fold], &fit);
        let noise = squares(carried, &self.carried, &fit);
        Some((fit, left, noise))
    }
}
