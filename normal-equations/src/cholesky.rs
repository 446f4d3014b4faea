//! Cholesky factors of many columns, in blocks that are as fast as a product of matrices (Golub and Van Loan 2013, section 4.2).

use nalgebra::{DMatrix, DMatrixViewMut, DVector};

/// Columns of a block. Cost alone: of 24 to 96 the fastest, as was measured for 100 to 1,200 columns.
pub(crate) const BLOCK: usize = 64;

/// The factor of a symmetric matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    /// Its lower triangle; zeros above.
    lower: DMatrix<f64>,
    /// Inverses of its diagonal blocks but the last, which only an inverse needs.
    diagonal: Vec<DMatrix<f64>>,
}

impl Factor {
    /// Of a matrix, of which the lower triangle is read; its memory is used. None where it is not positive definite. Cost: a third
    /// of the cube.
    #[must_use]
    pub fn new(mut matrix: DMatrix<f64>) -> Option<Self> {
        let n = matrix.nrows();
        let mut diagonal = Vec::new();
        if n <= BLOCK {
            let lower = matrix.cholesky()?.unpack();
            return Some(Self { lower, diagonal });
        }
        for first in (0..n).step_by(BLOCK) {
            let size = BLOCK.min(n - first);
            let next = first + size;
            let own = matrix.view((first, first), (size, size)).into_owned();
            let own = own.cholesky()?.unpack();
            matrix
                .view_mut((first, first), (size, size))
                .copy_from(&own);
            if next == n {
                break;
            }
            let inverse = triangle_inverse(&own);
            let below = matrix.view((next, first), (n - next, size)) * inverse.transpose();
            matrix
                .view_mut((next, first), (n - next, size))
                .copy_from(&below);
            let across = below.transpose();
            let rest = matrix.view_mut((next, next), (n - next, n - next));
            by_columns(rest, 0, &|column, mut part| {
                let (rows, width) = (n - next - column, part.ncols());
                let (left, right) = (below.rows(column, rows), across.columns(column, width));
                part.rows_mut(column, rows).gemm(-1.0, &left, &right, 1.0);
            });
            diagonal.push(inverse);
        }
        matrix.fill_upper_triangle(0.0, 1);
        Some(Self {
            lower: matrix,
            diagonal,
        })
    }

    /// Solution for a right side.
    #[must_use]
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let forward = self.lower.solve_lower_triangular(right);
        forward
            .and_then(|forward| self.lower.tr_solve_lower_triangular(&forward))
            .unwrap_or_else(|| DVector::zeros(right.len()))
    }

    /// Deviation of a linear function of what has the matrix's inverse for its covariance. Cost: half the square of the columns.
    #[must_use]
    pub fn deviation(&self, function: &DVector<f64>) -> f64 {
        self.half(function).norm()
    }

    /// The factor's inverse times a linear function: its product with that of another function is the covariance of both.
    #[must_use]
    pub fn half(&self, function: &DVector<f64>) -> DVector<f64> {
        let half = self.lower.solve_lower_triangular(function);
        half.unwrap_or_else(|| DVector::repeat(function.len(), f64::INFINITY))
    }

    /// A draw of unit normal numbers as one of the matrix's inverse for its covariance.
    #[must_use]
    pub fn coloured(&self, unit: &DVector<f64>) -> DVector<f64> {
        let drawn = self.lower.tr_solve_lower_triangular(unit);
        drawn.unwrap_or_else(|| DVector::zeros(unit.len()))
    }

    /// Half the logarithm of the determinant.
    #[must_use]
    pub fn half_log_determinant(&self) -> f64 {
        self.lower.diagonal().iter().map(|d| d.ln()).sum()
    }

    /// Inverse of the factor, a lower triangle, in its memory. Cost: a third of the cube.
    #[must_use]
    pub fn lower_inverse(self) -> DMatrix<f64> {
        let mut out = self.lower;
        let n = out.nrows();
        let mut diagonal = self.diagonal.into_iter();
        for first in (0..n).step_by(BLOCK) {
            let size = BLOCK.min(n - first);
            let last = || triangle_inverse(&out.view((first, first), (size, size)).into_owned());
            let own = diagonal.next().unwrap_or_else(last);
            // The rows above are inverted already.
            let before = -(&own * out.view((first, 0), (size, first)));
            let mut left = DMatrix::zeros(size, first);
            by_columns(left.as_view_mut(), 0, &|column, mut part| {
                let rows = first - column;
                let above = out.view((column, column), (rows, part.ncols()));
                part.gemm(1.0, &before.columns(column, rows), &above, 0.0);
            });
            out.view_mut((first, 0), (size, first)).copy_from(&left);
            out.view_mut((first, first), (size, size)).copy_from(&own);
        }
        out
    }

    /// Inverse of the matrix, in its memory. Cost: two thirds of the cube.
    #[must_use]
    pub fn inverse(self) -> DMatrix<f64> {
        let mut out = self.lower_inverse();
        let n = out.nrows();
        for first in (0..n).step_by(BLOCK) {
            let size = BLOCK.min(n - first);
            // The columns from here on are still the factor's inverse.
            let own = out.view((first, first), (n - first, size)).transpose();
            let mut part = DMatrix::zeros(size, n - first);
            by_columns(part.as_view_mut(), 0, &|column, mut part| {
                let rows = n - first - column;
                let half = out.view((first + column, first + column), (rows, part.ncols()));
                part.gemm(1.0, &own.columns(column, rows), &half, 0.0);
            });
            out.view_mut((first, first), (n - first, size))
                .copy_from(&part.transpose());
        }
        out.fill_upper_triangle_with_lower_triangle();
        out
    }
}

/// Inverse of a small lower triangle, column by column. Cost: a sixth of the cube.
fn triangle_inverse(lower: &DMatrix<f64>) -> DMatrix<f64> {
    let n = lower.nrows();
    let mut out = DMatrix::zeros(n, n);
    for column in 0..n {
        let mut own = out.column_mut(column);
        own[column] = 1.0;
        for row in column..n {
            let value = own[row] / lower[(row, row)];
            own[row] = value;
            let below = lower.column(row);
            own.rows_range_mut(row + 1..)
                .axpy(-value, &below.rows_range(row + 1..), 1.0);
        }
    }
    out
}

/// Works on all columns of a matrix, blocks of them side by side; `of` is told a block's first.
fn by_columns(
    mut matrix: DMatrixViewMut<f64>,
    first: usize,
    of: &(impl Fn(usize, DMatrixViewMut<f64>) + Sync),
) {
    let width = matrix.ncols();
    if width <= BLOCK {
        of(first, matrix);
        return;
    }
    let half = width.div_ceil(BLOCK) / 2 * BLOCK;
    let (left, right) = matrix.columns_range_pair_mut(..half, half..);
    rayon::join(
        || by_columns(left, first, of),
        || by_columns(right, first + half, of),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn factor_inverse_and_solution_are_those_of_the_plain_ones() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [1, 5, BLOCK, BLOCK + 1, 2 * BLOCK + 17] {
            let rows = DMatrix::from_fn(n + 40, n, |_, _| StandardNormal.sample(&mut rng));
            let matrix = rows.tr_mul(&rows) + DMatrix::identity(n, n);
            let plain = matrix.clone().cholesky().unwrap();
            let factor = Factor::new(matrix.clone()).unwrap();
            let right = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
            assert!((factor.solve(&right) - plain.solve(&right)).amax() < 1e-9);
            let wanted: f64 = plain.l().diagonal().iter().map(|d| d.ln()).sum();
            let deviation = right.dot(&plain.solve(&right)).sqrt();
            assert!((factor.deviation(&right) - deviation).abs() < 1e-9 * deviation);
            assert!((factor.half_log_determinant() - wanted).abs() < 1e-9 * n as f64);
            assert!((factor.inverse() - plain.inverse()).amax() < 1e-9);
        }
        assert!(Factor::new(DMatrix::from_element(2, 2, -1.0)).is_none());
    }
}
