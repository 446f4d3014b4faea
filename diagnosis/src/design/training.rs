//! What a model is trained on: the products of all folds but one.

use nalgebra::{DMatrix, DVector};
use normal_equations::symmetric::Symmetric;
use rayon::prelude::*;

/// Columns that are formed one after the other. Cost alone: below, to share the columns out costs more than to form them.
const SERIAL: usize = 64;

/// Sum over all folds but one, or over all: formed as it is asked for, without memory of its own.
#[derive(Clone, Copy)]
pub struct Training<'a> {
    total: &'a Symmetric,
    /// The fold that is left out.
    test: Option<&'a Symmetric>,
}

impl<'a> Training<'a> {
    /// A sum less the fold that is left out.
    pub fn new(total: &'a Symmetric, test: Option<&'a Symmetric>) -> Self {
        Self { total, test }
    }

    /// A sum that was formed already.
    pub fn of(total: &'a Symmetric) -> Self {
        Self { total, test: None }
    }

    /// The sum itself, to be changed.
    pub fn formed(&self) -> Symmetric {
        let mut sum = self.total.clone();
        if let Some(test) = self.test {
            sum -= test;
        }
        sum
    }

    /// An element.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        let total = self.total[(row, column)];
        self.test.map_or(total, |test| total - test[(row, column)])
    }

    /// Number of the target's row and column.
    pub fn last(&self) -> usize {
        self.total.order() - 1
    }

    /// Some rows and columns.
    pub fn block(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), columns.len(), |a, b| {
            self.at(rows[a], columns[b])
        })
    }

    /// The same rows as columns: each element is formed once.
    pub fn square(&self, list: &[usize]) -> DMatrix<f64> {
        let mut out = self.lower(list);
        out.fill_upper_triangle_with_lower_triangle();
        out
    }

    /// The lower triangle of that; zeros above.
    pub fn lower(&self, list: &[usize]) -> DMatrix<f64> {
        let n = list.len();
        let mut out = DMatrix::zeros(n, n);
        let columns = out.as_mut_slice().par_chunks_mut(n.max(1)).enumerate();
        columns.with_min_len(SERIAL).for_each(|(b, out)| {
            let total = self.total.below(list[b]);
            let test = self.test.map(|test| test.below(list[b]));
            for (out, &row) in out[b..].iter_mut().zip(&list[b..]) {
                *out = match row.checked_sub(list[b]) {
                    Some(at) => total[at] - test.map_or(0.0, |test| test[at]),
                    None => self.at(row, list[b]),
                };
            }
        });
        out
    }

    /// Products of some columns with the target.
    pub fn right(&self, columns: &[usize]) -> DVector<f64> {
        DVector::from_fn(columns.len(), |a, _| self.at(columns[a], self.last()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_formed_of_columns_in_any_order() {
        let filled = |by: f64| {
            let mut sum = Symmetric::zeros(6);
            for column in 0..6 {
                let below = sum.below_mut(column).iter_mut().enumerate();
                below.for_each(|(k, slot)| *slot = by * (10 * column + k) as f64);
            }
            sum
        };
        let (total, test) = (filled(3.0), filled(1.0));
        for list in [vec![0, 2, 3, 5], vec![4, 1, 3, 0]] {
            for test in [None, Some(&test)] {
                let training = Training::new(&total, test);
                assert_eq!(training.square(&list), training.block(&list, &list));
            }
        }
    }
}
