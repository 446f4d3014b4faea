//! Whether values differ from zero beyond chance, all together.

use crate::distribution::chance_of_mean_square;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Directions with less than this share of the largest variance, each unknown counted in its own deviation, are none: what
/// rounding leaves of a covariance that was stored in f32 or written in ten digits. Derived from ten digits, of which a sum loses
/// one.
const NO_VARIANCE: f64 = 1.0e-9;
/// A difference that is less than this many deviations of its unknown is none, where no direction allows any. Derived from
/// squares: it would add a millionth to the sum that is judged.
const UNFELT: f64 = 1.0e-3;

/// A joint test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointTest {
    /// Mean square of the difference over its directions, each in its standard deviation: about one by chance.
    pub mean_square: f64,
    /// Directions that were tested: the rank of the covariance.
    pub directions: usize,
    /// Unknowns that were estimated. More than directions: some combinations are fixed by convention, and are left out.
    pub unknowns: usize,
    /// Degrees of freedom of the scale; none where it is known.
    pub freedom: Option<f64>,
    /// Probability that chance alone gives as much or more.
    pub chance: f64,
    /// Whether values differ where the covariance says that they cannot: the conventions are not the same.
    pub convention_differs: bool,
}

/// A root of a covariance: its directions that have variance, as columns.
#[derive(Clone, Debug)]
pub struct Root {
    /// `root * root^T` is the covariance.
    pub root: DMatrix<f64>,
    /// Its pseudo-inverse.
    pub inverse: DMatrix<f64>,
    deviations: Vec<f64>,
}

impl Root {
    /// Of a covariance; unknowns without variance have no share in it. Cost: some twenty times the cube of the unknowns.
    #[must_use]
    pub fn of(covariance: &DMatrix<f64>) -> Self {
        let n = covariance.nrows();
        let deviations: Vec<f64> = covariance
            .diagonal()
            .iter()
            .map(|v| v.max(0.0).sqrt())
            .collect();
        let unit = |k: usize| {
            if deviations[k] > 0.0 {
                1.0 / deviations[k]
            } else {
                0.0
            }
        };
        let related = DMatrix::from_fn(n, n, |a, b| covariance[(a, b)] * unit(a) * unit(b));
        let eigen = related.symmetric_eigen();
        let limit = NO_VARIANCE * eigen.eigenvalues.iter().fold(0.0_f64, |a, b| a.max(*b));
        let kept: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] > limit).collect();
        let size = |k: usize| eigen.eigenvalues[kept[k]].sqrt();
        let along = |a: usize, k: usize| eigen.eigenvectors[(a, kept[k])];
        Self {
            root: DMatrix::from_fn(n, kept.len(), |a, k| deviations[a] * along(a, k) * size(k)),
            inverse: DMatrix::from_fn(kept.len(), n, |k, a| unit(a) * along(a, k) / size(k)),
            deviations,
        }
    }

    /// Directions that have variance.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.root.ncols()
    }

    /// Tests values against zero. Unknowns without variance are no part of it.
    #[must_use]
    pub fn test(&self, values: &DVector<f64>, freedom: f64) -> JointTest {
        let white = &self.inverse * values;
        let told = &self.root * &white;
        let off = |k: usize| (values[k] - told[k]).abs() / self.deviations[k];
        let estimated: Vec<usize> = (0..values.len())
            .filter(|&k| self.deviations[k] > 0.0)
            .collect();
        let mean_square = white.norm_squared() / self.rank().max(1) as f64;
        JointTest {
            mean_square,
            directions: self.rank(),
            unknowns: estimated.len(),
            freedom: freedom.is_finite().then_some(freedom),
            chance: chance_of_mean_square(mean_square, self.rank(), freedom),
            convention_differs: estimated.into_iter().any(|k| off(k) > UNFELT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_covariance_is_tested_in_all_its_directions() {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        let values = DVector::from_column_slice(&[1.0, -2.0]);
        let wanted = (values.transpose() * covariance.clone().try_inverse().unwrap() * &values)
            [(0, 0)]
            / 2.0;
        let test = Root::of(&covariance).test(&values, f64::INFINITY);
        assert!(
            (test.mean_square - wanted).abs() < 1.0e-12 && test.directions == 2,
            "{test:?}"
        );
        assert!(!test.convention_differs && test.freedom.is_none());
    }

    /// Two unknowns of which only the difference is told, of sizes that are far apart, and one that was held.
    #[test]
    fn a_gauge_is_left_out_and_a_change_of_it_is_named() {
        let vector = DVector::from_column_slice(&[1.0e-6, -1.0, 0.0]);
        let root = Root::of(&(&vector * vector.transpose()));
        let test = root.test(&DVector::from_column_slice(&[2.0e-6, -2.0, 5.0]), 50.0);
        assert_eq!((test.directions, test.unknowns), (1, 2));
        assert!(
            (test.mean_square - 4.0).abs() < 1.0e-9 && !test.convention_differs,
            "{test:?}"
        );
        let other = root.test(&DVector::from_column_slice(&[2.0e-6, 2.0, 0.0]), 50.0);
        assert!(
            other.convention_differs && other.mean_square < 1.0e-9,
            "{other:?}"
        );
    }
}
