//! Cholesky factors of many columns, in blocks that are as fast as a product of matrices (Golub and Van Loan 2013, section 4.2).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Columns of a block.
const BLOCK: usize = 96;

/// The factor of a symmetric matrix.
pub struct Factor {
    /// Its lower triangle; zeros above.
    lower: DMatrix<f64>,
    /// Inverses of its diagonal blocks.
    diagonal: Vec<DMatrix<f64>>,
}

impl Factor {
    /// Of a matrix, of which the lower triangle is read. None where it is not positive definite. Cost: a third of the cube.
    pub fn new(mut matrix: DMatrix<f64>) -> Option<Self> {
        let n = matrix.nrows();
        let mut diagonal = Vec::new();
        for first in (0..n).step_by(BLOCK) {
            let size = BLOCK.min(n - first);
            let next = first + size;
            let own = matrix.view((first, first), (size, size)).into_owned();
            let own = own.cholesky()?.unpack();
            let inverse = own.solve_lower_triangular(&DMatrix::identity(size, size))?;
            matrix
                .view_mut((first, first), (size, size))
                .copy_from(&own);
            let below = matrix.view((next, first), (n - next, size)) * inverse.transpose();
            matrix
                .view_mut((next, first), (n - next, size))
                .copy_from(&below);
            let across = below.transpose();
            let taken = blocks(0..n - next, |column, width| {
                below.rows(column, n - next - column) * across.columns(column, width)
            });
            for (column, part) in taken {
                let mut rest = matrix.view_mut((next + column, next + column), part.shape());
                rest -= part;
            }
            diagonal.push(inverse);
        }
        matrix.fill_upper_triangle(0.0, 1);
        Some(Self {
            lower: matrix,
            diagonal,
        })
    }

    /// Solution for a right side.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let forward = self.lower.solve_lower_triangular(right);
        forward
            .and_then(|forward| self.lower.tr_solve_lower_triangular(&forward))
            .unwrap_or_else(|| DVector::zeros(right.len()))
    }

    /// A draw of unit normal numbers as one of the matrix's inverse for its covariance.
    pub fn coloured(&self, unit: &DVector<f64>) -> DVector<f64> {
        let drawn = self.lower.tr_solve_lower_triangular(unit);
        drawn.unwrap_or_else(|| DVector::zeros(unit.len()))
    }

    /// Half the logarithm of the determinant.
    pub fn half_log_determinant(&self) -> f64 {
        self.lower.diagonal().iter().map(|d| d.ln()).sum()
    }

    /// Inverse of the factor, a lower triangle. Cost: a third of the cube.
    pub fn lower_inverse(&self) -> DMatrix<f64> {
        let n = self.lower.nrows();
        let mut out = DMatrix::zeros(n, n);
        for (row, own) in self.diagonal.iter().enumerate() {
            let first = row * BLOCK;
            let size = own.nrows();
            let before = self.lower.view((first, 0), (size, first));
            let left = blocks(0..first, |column, width| {
                let rows = first - column;
                let above = out.view((column, column), (rows, width));
                -(own * (before.columns(column, rows) * above))
            });
            for (column, part) in left {
                out.view_mut((first, column), part.shape()).copy_from(&part);
            }
            out.view_mut((first, first), (size, size)).copy_from(own);
        }
        out
    }

    /// Inverse of the matrix. Cost: two thirds of the cube and that of [`Self::lower_inverse`].
    pub fn inverse(&self) -> DMatrix<f64> {
        let half = self.lower_inverse();
        let across = half.transpose();
        let n = half.nrows();
        let mut out = DMatrix::zeros(n, n);
        // Rows from a block's own on: above them its columns are zero.
        let parts = blocks(0..n, |column, width| {
            let left = across.view((column, column), (n - column, n - column));
            left * half.view((column, column), (n - column, width))
        });
        for (column, part) in parts {
            out.view_mut((column, column), part.shape())
                .copy_from(&part);
        }
        out.fill_upper_triangle_with_lower_triangle();
        out
    }
}

/// A matrix for each block of columns, told by its first and its width, side by side.
fn blocks(
    columns: Range<usize>,
    of: impl Fn(usize, usize) -> DMatrix<f64> + Sync,
) -> Vec<(usize, DMatrix<f64>)> {
    let firsts: Vec<usize> = columns.clone().step_by(BLOCK).collect();
    let one = |first: usize| (first, of(first, BLOCK.min(columns.end - first)));
    if firsts.len() > 2 {
        firsts.into_par_iter().map(one).collect()
    } else {
        firsts.into_iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    #[test]
    fn factor_inverse_and_solution_are_those_of_the_plain_ones() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [1, 5, BLOCK, BLOCK + 1, 2 * BLOCK + 17] {
            let rows = DMatrix::from_fn(n + 40, n, |_, _| normal(&mut rng));
            let matrix = rows.tr_mul(&rows) + DMatrix::identity(n, n);
            let plain = matrix.clone().cholesky().unwrap();
            let factor = Factor::new(matrix.clone()).unwrap();
            assert!((factor.inverse() - plain.inverse()).amax() < 1e-9);
            let right = DVector::from_fn(n, |_, _| normal(&mut rng));
            assert!((factor.solve(&right) - plain.solve(&right)).amax() < 1e-9);
            let wanted: f64 = plain.l().diagonal().iter().map(|d| d.ln()).sum();
            assert!((factor.half_log_determinant() - wanted).abs() < 1e-9 * n as f64);
        }
        assert!(Factor::new(DMatrix::from_element(2, 2, -1.0)).is_none());
    }
}
