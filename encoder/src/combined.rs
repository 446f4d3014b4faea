//! Adding up what independent pieces of data tell: least squares, and how well it is known by the pieces' own scatter.

use nalgebra::{DMatrix, DVector};

/// What one piece tells: `rows * x = right`, whitened by its own noise.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub rows: DMatrix<f64>,
    pub right: DVector<f64>,
}

/// A solution.
#[derive(Clone, Debug)]
pub(crate) struct Combined {
    pub values: DVector<f64>,
    /// By leaving each piece out in turn (jackknife; Efron and Tibshirani 1993, chapter 11): right also where pieces are noisier than
    /// their own residuals say, and where orders differ in that.
    pub covariance: DMatrix<f64>,
    pub pieces: usize,
}

impl Combined {
    pub fn deviation(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0).sqrt()
    }

    /// Root of the mean square of two numbers' deviations.
    pub fn deviation_of_pair(&self, index: usize) -> f64 {
        (0.5 * (self.covariance[(index, index)] + self.covariance[(index + 1, index + 1)]))
            .max(0.0)
            .sqrt()
    }

    /// Half the square of two numbers in units of their covariance: an F ratio of 2 and as many freedoms as there are pieces less one.
    pub fn ratio_of_pair(&self, index: usize) -> f64 {
        let value = self.values.fixed_rows::<2>(index).into_owned();
        let covariance = self
            .covariance
            .fixed_view::<2, 2>(index, index)
            .into_owned();
        covariance
            .try_inverse()
            .map_or(0.0, |inverse| 0.5 * value.dot(&(inverse * value)))
    }
}

/// Solves; none if the pieces do not determine every unknown, or are fewer than two.
pub(crate) fn combined(pieces: &[Piece]) -> Option<Combined> {
    let unknowns = pieces.first()?.rows.ncols();
    let products: Vec<(DMatrix<f64>, DVector<f64>)> = pieces
        .iter()
        .map(|piece| {
            (
                piece.rows.tr_mul(&piece.rows),
                piece.rows.tr_mul(&piece.right),
            )
        })
        .collect();
    let mut matrix = DMatrix::zeros(unknowns, unknowns);
    let mut right = DVector::zeros(unknowns);
    for (of, to) in &products {
        matrix += of;
        right += to;
    }
    let values = solution(&matrix, &right)?;
    let count = pieces.len();
    if count < 2 {
        return None;
    }
    let mut covariance = DMatrix::zeros(unknowns, unknowns);
    for (of, to) in &products {
        let without = solution(&(&matrix - of), &(&right - to))?;
        let difference = without - &values;
        covariance += &difference * difference.transpose();
    }
    covariance *= (count - 1) as f64 / count as f64;
    Some(Combined {
        values,
        covariance,
        pieces: count,
    })
}

/// Columns brought to equal length first. None where a direction is not determined.
fn solution(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    /// Smallest pivot of a matrix with a unit diagonal. Derived from f32, in whose rows 1e-7 of a column's length is rounding,
    /// 1e-14 of the product: well above it, what is weaker than 3e-5 of its column is not determined.
    const LEAST_PIVOT: f64 = 1.0e-9;
    let scale = matrix.diagonal().map(|square| {
        if square > 0.0 {
            1.0 / square.sqrt()
        } else {
            0.0
        }
    });
    if scale.iter().any(|scale| *scale == 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        matrix[(i, j)] * scale[i] * scale[j]
    });
    let factor = scaled.cholesky()?;
    if factor
        .l_dirty()
        .diagonal()
        .iter()
        .any(|pivot| pivot * pivot < LEAST_PIVOT)
    {
        return None;
    }
    Some(
        factor
            .solve(&right.component_mul(&scale))
            .component_mul(&scale),
    )
}
