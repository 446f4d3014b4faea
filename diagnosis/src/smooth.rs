//! Sparse rows fitted by least squares with a prior, and what such a fit leaves on pieces that it has not seen.

use crate::gram::FOLDS;
use nalgebra::{DMatrix, DVector};

/// One value and the few columns that it depends on.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Column and entry.
    pub entries: Vec<(usize, f64)>,
    /// What is to be explained.
    pub value: f64,
    /// Piece that the row belongs to.
    pub fold: usize,
}

/// A fit of all rows.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Amount of each column.
    pub amounts: DVector<f64>,
    /// Mean square that fits of the other pieces leave.
    pub held_out: f64,
}

/// Products of the columns with each other and with the values, and the values' squares.
#[derive(Clone)]
struct Sums {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
}

impl Sums {
    fn new(columns: usize) -> Self {
        Self {
            normal: DMatrix::zeros(columns, columns),
            right: DVector::zeros(columns),
            squares: 0.0,
        }
    }

    fn add(&mut self, row: &Row) {
        for &(a, x) in &row.entries {
            for &(b, y) in &row.entries {
                self.normal[(a, b)] += x * y;
            }
            self.right[a] += x * row.value;
        }
        self.squares += row.value * row.value;
    }

    /// Amounts of unit prior against noise of this variance.
    fn solve(&self, noise: f64) -> Option<DVector<f64>> {
        let mut normal = self.normal.clone();
        for k in 0..normal.nrows() {
            normal[(k, k)] += noise;
        }
        Some(normal.cholesky()?.solve(&self.right))
    }

    fn left(&self, amounts: &DVector<f64>) -> f64 {
        self.squares - 2.0 * self.right.dot(amounts) + amounts.dot(&(&self.normal * amounts))
    }
}

/// Fits rows over `columns` whose amounts are expected about 1, with noise of variance `noise`. Cost: rows times the square of
/// their entries, and columns cubed for each piece.
pub fn fit(columns: usize, rows: &[Row], noise: f64) -> Option<Fit> {
    let mut folds = vec![Sums::new(columns); FOLDS];
    for row in rows {
        folds[row.fold].add(row);
    }
    let mut all = Sums::new(columns);
    for fold in &folds {
        all.normal += &fold.normal;
        all.right += &fold.right;
        all.squares += fold.squares;
    }
    let mut left = 0.0;
    for fold in &folds {
        let others = Sums {
            normal: &all.normal - &fold.normal,
            right: &all.right - &fold.right,
            squares: all.squares - fold.squares,
        };
        left += fold.left(&others.solve(noise)?);
    }
    Some(Fit {
        amounts: all.solve(noise)?,
        held_out: left / rows.len().max(1) as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_a_foreign_column_explains_nothing() {
        let rows = |column: fn(f64) -> f64| -> Vec<Row> {
            let one = |k: usize| {
                let x = k as f64 / 500.0 - 1.0;
                let entries = vec![(0, 1.0), (1, column(x))];
                Row {
                    entries,
                    value: 0.3 * x,
                    fold: k * 40 / 1000 % FOLDS,
                }
            };
            (0..1000).map(one).collect()
        };
        let line = fit(2, &rows(|x| x), 1e-9).expect("regular");
        assert!((line.amounts[1] - 0.3).abs() < 1e-6 && line.held_out < 1e-9);
        let other = fit(2, &rows(|x| (300.0 * x).sin()), 1e-9).expect("regular");
        assert!(other.held_out > 0.029);
    }
}
