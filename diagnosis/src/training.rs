//! What a model is trained on: the products of all folds but one.

use crate::symmetric::Symmetric;
use nalgebra::{DMatrix, DVector};

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
        let mut out = DMatrix::zeros(list.len(), list.len());
        for (b, &column) in list.iter().enumerate() {
            for (a, &row) in list.iter().enumerate().skip(b) {
                out[(a, b)] = self.at(row, column);
            }
        }
        out.fill_upper_triangle_with_lower_triangle();
        out
    }

    /// Products of some columns with the target.
    pub fn right(&self, columns: &[usize]) -> DVector<f64> {
        DVector::from_fn(columns.len(), |a, _| self.at(columns[a], self.last()))
    }
}
