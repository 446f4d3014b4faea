//! Normal equations of some columns over a part of a recording: what one part foretells of another is small algebra on them.

use nalgebra::{DMatrix, DVector};

/// Products of columns, and of them with what the residuals would be without any, over a part of a recording.
pub struct Sums {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
    /// What holds each amount at zero: 1 where columns are those of one prior deviation.
    prior: f64,
}

impl Sums {
    /// Of no rows.
    pub fn new(columns: usize, prior: f64) -> Self {
        Self {
            normal: DMatrix::zeros(columns, columns),
            right: DVector::zeros(columns),
            squares: 0.0,
            prior,
        }
    }

    /// Adds a row, whitened: the columns there, and what would be left without any.
    pub fn add(&mut self, columns: &DVector<f64>, without: f64) {
        self.normal.ger(1.0, columns, columns, 1.0);
        self.right.axpy(without, columns, 1.0);
        self.squares += without * without;
    }

    /// Normal equations of some columns.
    fn of(&self, list: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
        let normal = DMatrix::from_fn(list.len(), list.len(), |r, c| {
            self.normal[(list[r], list[c])]
        });
        let right = DVector::from_fn(list.len(), |r, _| self.right[list[r]]);
        (normal, right)
    }

    /// Amounts of some columns that leave least; `None` where they cannot be told.
    pub fn coefficients(&self, list: &[usize]) -> Option<DVector<f64>> {
        let (mut normal, right) = self.of(list);
        for k in 0..list.len() {
            normal[(k, k)] += self.prior;
        }
        normal.cholesky().map(|factors| -factors.solve(&right))
    }

    /// Whitened squares that some columns leave here, with amounts of their own or of another part.
    pub fn left_with(&self, list: &[usize], coefficients: Option<DVector<f64>>) -> f64 {
        let (normal, right) = self.of(list);
        coefficients.map_or(f64::INFINITY, |coefficients| {
            self.squares
                + 2.0 * coefficients.dot(&right)
                + coefficients.dot(&(normal * &coefficients))
        })
    }

    /// Whitened squares that some columns leave here at best.
    pub fn left(&self, list: &[usize]) -> f64 {
        self.left_with(list, self.coefficients(list))
    }
}
