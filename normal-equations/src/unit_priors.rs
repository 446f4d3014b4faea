//! The solution of normal equations whose unknowns have independent priors of unit deviation (ridge regression: Hoerl and Kennard 1970).

use crate::cholesky::Factor;
use nalgebra::{DMatrix, DVector};

/// Unknowns, and the factor of their precision: its inverse is their posterior covariance.
pub struct Solution {
    /// Means.
    pub values: DVector<f64>,
    /// Of products of columns plus one for each prior.
    pub factor: Factor,
    /// Products of columns with what is to be explained, plus the prior means.
    pub right: DVector<f64>,
}

/// Solves for unknowns with unit normal priors about `centre`. Of `normal`, the whitened columns' products with each other, the lower
/// triangle is read; `right` are those with what is to be explained. None where the precision is not positive definite: a row that is
/// no number. Cost: a third of the cube.
pub fn solve(
    mut normal: DMatrix<f64>,
    mut right: DVector<f64>,
    centre: impl IntoIterator<Item = f64>,
) -> Option<Solution> {
    for (k, centre) in centre.into_iter().enumerate() {
        right[k] += centre;
    }
    for k in 0..normal.nrows() {
        normal[(k, k)] += 1.0;
    }
    let factor = Factor::new(normal)?;
    Some(Solution {
        values: factor.solve(&right),
        factor,
        right,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mean of n readings with a prior: known in closed form.
    #[test]
    fn a_mean_is_drawn_to_its_prior() {
        let (n, sum, centre) = (9.0, 27.0, 1.0);
        let normal = DMatrix::from_element(1, 1, n);
        let solution = solve(normal, DVector::from_element(1, sum), [centre]).unwrap();
        assert!((solution.values[0] - (sum + centre) / (n + 1.0)).abs() < 1e-12);
        let deviation = solution.factor.deviation(&DVector::from_element(1, 2.0));
        assert!((deviation - 2.0 / (n + 1.0_f64).sqrt()).abs() < 1e-12);
    }
}
