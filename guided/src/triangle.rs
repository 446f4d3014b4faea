//! The triangle of a motion's rows: what they determine of the unknowns, and which of these look alike.
//!
//! Rows are whitened, so the inverse of the triangle's square is the covariance. Further rows are added to it, which costs the square of
//! the unknowns a row, and the rows need not be kept.

use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest, columns equally long, are nothing. Derived from f32: the rows have seven
/// digits.
pub const UNDETERMINED: f64 = 1.0e-5;
/// A column that moves all rows together by less than this many deviations, the unknown off by its prior's, is rounding. Derived
/// from squares: a ten-thousandth of what one unknown is told by.
const UNFELT: f64 = 1.0e-2;
/// Shares of an undetermined direction below this are rounding. Derived from f32, whose squares have fourteen digits.
const NOTHING: f64 = 1.0e-8;

/// A triangle.
#[derive(Clone, Debug)]
pub struct Triangle {
    /// As the rows are.
    sum: DMatrix<f64>,
    /// Columns equally long.
    even: DMatrix<f64>,
    lengths: Vec<f64>,
    priors: Vec<f64>,
}

impl Triangle {
    /// Of no rows yet; `priors` are the deviations that are believed before, in the units of the unknowns.
    #[must_use]
    pub fn new(priors: Vec<f64>) -> Self {
        let n = priors.len();
        Self {
            sum: DMatrix::zeros(0, n),
            even: DMatrix::zeros(0, n),
            lengths: vec![1.0; n],
            priors,
        }
    }

    /// With further rows, `[rows, unknowns]`, in deviations of their noise.
    #[must_use]
    pub fn with(mut self, rows: &DMatrix<f64>) -> Self {
        let n = self.priors.len();
        let (before, added) = (self.sum.nrows(), rows.nrows());
        // At least as many rows as unknowns: else directions that no row is of would not be seen at all.
        let mut stacked = DMatrix::zeros((before + added).max(n), n);
        stacked.view_mut((0, 0), (before, n)).copy_from(&self.sum);
        stacked.view_mut((before, 0), (added, n)).copy_from(rows);
        self.sum = stacked.qr().unpack_r();
        self.even = self.sum.clone();
        self.lengths = self.even.column_iter().map(|c| c.norm()).collect();
        for ((mut column, length), prior) in self
            .even
            .column_iter_mut()
            .zip(&mut self.lengths)
            .zip(&self.priors)
        {
            if *length * prior < UNFELT {
                column.fill(0.0);
                *length = 1.0;
            } else {
                column /= *length;
            }
        }
        self
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.priors.len()
    }

    /// Deviation that is believed before.
    #[must_use]
    pub fn prior(&self, column: usize) -> f64 {
        self.priors[column]
    }

    /// Condition number, columns equally long, where all is determined; and how many directions are not.
    #[must_use]
    pub fn condition(&self) -> (Option<f64>, usize) {
        let singular = self.even.clone().singular_values();
        let largest = singular.max();
        let undetermined = self.unknowns()
            - singular
                .iter()
                .filter(|&&s| s > UNDETERMINED * largest)
                .count();
        let number = (undetermined == 0).then(|| largest / singular.min());
        (number, undetermined)
    }

    /// Predicted variances by the rows alone, infinite where undetermined.
    #[must_use]
    pub fn variances(&self) -> Vec<f64> {
        let n = self.unknowns();
        let svd = self.even.clone().svd(false, true);
        let Some(right) = svd.v_t else {
            return vec![f64::INFINITY; n];
        };
        let largest = svd.singular_values.max();
        let variance = |column: usize| {
            let parts = svd.singular_values.iter().enumerate().map(|(k, s)| {
                let share = right[(k, column)].powi(2);
                if *s > UNDETERMINED * largest {
                    share / (s * s)
                } else if share > NOTHING {
                    f64::INFINITY
                } else {
                    0.0
                }
            });
            parts.sum::<f64>() / self.lengths[column].powi(2)
        };
        (0..n).map(variance).collect()
    }

    /// The same with what is believed before.
    #[must_use]
    pub fn variances_with_priors(&self) -> Vec<f64> {
        let n = self.unknowns();
        let rows = self.even.nrows();
        let mut stacked = DMatrix::zeros(rows + n, n);
        stacked.view_mut((0, 0), (rows, n)).copy_from(&self.even);
        for i in 0..n {
            stacked[(rows + i, i)] = 1.0 / (self.priors[i] * self.lengths[i]);
        }
        let triangle = stacked.qr().unpack_r();
        let variance = |column: usize| {
            let mut unit = DVector::zeros(n);
            unit[column] = 1.0 / self.lengths[column];
            triangle
                .tr_solve_upper_triangular(&unit)
                .map_or(f64::INFINITY, |v| v.norm_squared())
        };
        (0..n).map(variance).collect()
    }

    /// Smallest principal angle between two sets of columns, degrees: 90 is independent, 0 is the same (Björck and Golub 1973); by its sine,
    /// which is exact for small ones.
    #[must_use]
    pub fn angle_deg(&self, a: &[usize], b: &[usize]) -> f64 {
        if a.is_empty() || b.is_empty() {
            return 90.0;
        }
        let [qa, qb] = [a, b].map(|columns| self.basis(columns));
        let rest = &qa - &qb * (qb.transpose() * &qa);
        let sine = if qa.ncols() == 0 {
            0.0
        } else {
            rest.singular_values().min()
        };
        sine.clamp(0.0, 1.0).asin().to_degrees()
    }

    /// Orthonormal basis of some columns' span; dependent ones give fewer.
    fn basis(&self, columns: &[usize]) -> DMatrix<f64> {
        let svd = self.even.select_columns(columns).svd(true, false);
        let keep: Vec<usize> = (0..svd.singular_values.len())
            .filter(|&i| svd.singular_values[i] > UNDETERMINED)
            .collect();
        svd.u.map_or_else(
            || DMatrix::zeros(self.even.nrows(), 0),
            |u| u.select_columns(&keep),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows that come in two parts tell what they tell together.
    #[test]
    fn rows_may_be_added_one_part_after_the_other() {
        let rows = DMatrix::from_fn(12, 3, |i, k| ((3 + 2 * i * k + i * i) as f64).sin());
        let at_once = Triangle::new(vec![1.0; 3]).with(&rows);
        let [first, second] =
            [0, 5].map(|from| rows.rows(from, if from == 0 { 5 } else { 7 }).into_owned());
        let in_parts = Triangle::new(vec![1.0; 3]).with(&first).with(&second);
        let pairs = at_once.variances().into_iter().zip(in_parts.variances());
        pairs.for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}"));
        assert!((at_once.angle_deg(&[0], &[1]) - in_parts.angle_deg(&[0], &[1])).abs() < 1e-9);
    }

    #[test]
    fn fewer_rows_than_unknowns_leave_directions_undetermined() {
        let row = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let triangle = Triangle::new(vec![1.0; 2]).with(&row);
        assert_eq!(triangle.condition(), (None, 1));
        assert!(triangle.variances().iter().all(|v| v.is_infinite()));
        let more = DMatrix::from_row_slice(1, 2, &[1.0, -1.0]);
        let variances = triangle.with(&more).variances();
        assert!(
            variances.iter().all(|v| (v - 0.5).abs() < 1e-12),
            "{variances:?}"
        );
    }

    #[test]
    fn what_no_row_moves_is_undetermined() {
        let rows = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 2.0, 0.0, 3.0, 0.0]);
        let triangle = Triangle::new(vec![1.0; 2]).with(&rows);
        assert_eq!(triangle.condition(), (None, 1));
        let [known, unknown] = triangle.variances()[..] else {
            panic!("two")
        };
        assert!((known - 1.0 / 14.0).abs() < 1e-12 && unknown.is_infinite());
        assert!((triangle.variances_with_priors()[1] - 1.0).abs() < 1e-12);
    }
}
