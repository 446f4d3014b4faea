//! Some columns beside others: what is left of them, and how well their amounts are known.

use nalgebra::DMatrix;

/// Products of some columns with what others explain of them taken out.
pub struct Given(pub DMatrix<f64>);

impl Given {
    /// Posterior variance of each amount over its prior's.
    pub fn variances(&self) -> Vec<f64> {
        let mut precision = self.0.clone();
        for k in 0..precision.nrows() {
            precision[(k, k)] += 1.0;
        }
        let inverse = precision.cholesky().map(|factor| factor.inverse());
        let n = self.0.nrows();
        inverse.map_or(vec![1.0; n], |inverse| {
            inverse.diagonal().iter().copied().collect()
        })
    }

    /// Expected whitened squares, amounts drawn from their priors.
    pub fn squares(&self) -> f64 {
        self.0.trace()
    }

    /// Logarithm of the determinant of precision over that of the prior, a column: how much is known, in the D-optimal sense.
    pub fn information(&self) -> f64 {
        let mut precision = self.0.clone();
        let n = precision.nrows();
        for k in 0..n {
            precision[(k, k)] += 1.0;
        }
        let Some(factor) = precision.cholesky() else {
            return 0.0;
        };
        let diagonal = factor.l_dirty().diagonal();
        2.0 * diagonal.iter().map(|d| d.ln()).sum::<f64>() / n.max(1) as f64
    }
}
