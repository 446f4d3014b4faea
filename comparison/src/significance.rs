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

/// How well the scale of a covariance is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Degrees of freedom; infinite where the noise is known.
    pub freedom: f64,
    /// Share of it, for each direction, that the estimate's own errors make: [`own_share`]. Zero where it was measured apart.
    pub own: f64,
}

impl Scale {
    /// A scale that was measured apart from the estimate.
    #[must_use]
    pub const fn apart(freedom: f64) -> Self {
        Self { freedom, own: 0.0 }
    }

    /// A mean square over so many directions, of those in which it was divided by the square of this scale: what the errors themselves add to
    /// the scale is taken out. The scale is `1 - own + own q` times the noise's where q is the mean square over the noise's, so that `q`
    /// follows from what was divided; the more it is, the more of the scale is its own.
    fn without_own(self, mean_square: f64, directions: usize) -> f64 {
        let own = self.own * directions as f64;
        let rest = 1.0 - own * mean_square;
        if rest > 0.0 {
            mean_square * (1.0 - own) / rest
        } else {
            f64::INFINITY
        }
    }
}

/// Share of a scale's square, for each of `unknowns`, that is the estimate's own error where held-out residuals measure it: they have the
/// variance `1 + leverage` for unit noise.
#[must_use]
pub fn own_share(leverage: f64, unknowns: usize) -> f64 {
    leverage / ((1.0 + leverage) * unknowns as f64)
}

/// Degrees of freedom of a scale that so many held-out residuals measure, twice over the variance of its square: their own noise is drawn that
/// often less one; the estimate's error, which all of them have, once, with the mean square `leverage` of them. That is a sum of squares over
/// its directions, and `squares` the sum of their weights' squares: `leverage^2 / n` where n directions count alike.
#[must_use]
pub fn held_out_freedom(held_out: f64, leverage: f64, squares: f64) -> f64 {
    let relative = (held_out - 1.0).recip() + squares;
    (1.0 + leverage) * (1.0 + leverage) / relative
}

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
    pub fn test(&self, values: &DVector<f64>, scale: Scale) -> JointTest {
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
            freedom: scale.freedom.is_finite().then_some(scale.freedom),
            chance: chance_of_mean_square(
                scale.without_own(mean_square, self.rank()),
                self.rank(),
                scale.freedom,
            ),
            convention_differs: estimated.into_iter().any(|k| off(k) > UNFELT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};

    #[test]
    fn a_full_covariance_is_tested_in_all_its_directions() {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        let values = DVector::from_column_slice(&[1.0, -2.0]);
        let wanted = (values.transpose() * covariance.clone().try_inverse().unwrap() * &values)
            [(0, 0)]
            / 2.0;
        let test = Root::of(&covariance).test(&values, Scale::apart(f64::INFINITY));
        assert!(
            (test.mean_square - wanted).abs() < 1.0e-12 && test.directions == 2,
            "{test:?}"
        );
        assert!(!test.convention_differs && test.freedom.is_none());
    }

    /// Differences of two estimates of 32 unknowns, whose errors add as much to 200 held-out residuals as the noise: of 20,000, one in twenty is
    /// called changed, to three deviations of that. Taken for scales that were measured apart, it is fewer than one in fifty.
    #[test]
    fn a_scale_that_has_the_errors_in_it_calls_one_in_twenty_changed() {
        const TRIES: u32 = 20_000;
        let (leverage, unknowns, held_out) = (1.0, 32, 200.0);
        let mut rng = ChaCha8Rng::seed_from_u64(391);
        let noise = ChiSquared::new(held_out - 1.0).unwrap();
        let mut side = || {
            let errors = DVector::<f64>::from_fn(unknowns, |_, _| StandardNormal.sample(&mut rng));
            let own = errors.norm_squared() / unknowns as f64;
            let measured = noise.sample(&mut rng) / (held_out - 1.0) + leverage * own;
            (errors, measured / (1.0 + leverage))
        };
        let scale = Scale {
            freedom: 2.0
                * held_out_freedom(held_out, leverage, leverage * leverage / unknowns as f64),
            own: 0.5 * own_share(leverage, unknowns),
        };
        let apart = Scale::apart(2.0 * (held_out - 1.0));
        let root = Root::of(&DMatrix::identity(unknowns, unknowns));
        let mut called = [0_u32; 2];
        for _ in 0..TRIES {
            let ((one, scale_one), (two, scale_two)) = (side(), side());
            let values = (two - one) / (scale_one + scale_two).sqrt();
            for (called, scale) in called.iter_mut().zip([scale, apart]) {
                *called += u32::from(root.test(&values, scale).chance < 0.05);
            }
        }
        let wanted = 0.05 * f64::from(TRIES);
        let off = f64::from(called[0]) - wanted;
        assert!(off.abs() < 3.0 * (0.95 * wanted).sqrt(), "{called:?}");
        assert!(called[1] < TRIES / 50, "{called:?}");
    }

    /// Two unknowns of which only the difference is told, of sizes that are far apart, and one that was held.
    #[test]
    fn a_gauge_is_left_out_and_a_change_of_it_is_named() {
        let vector = DVector::from_column_slice(&[1.0e-6, -1.0, 0.0]);
        let root = Root::of(&(&vector * vector.transpose()));
        let test = root.test(
            &DVector::from_column_slice(&[2.0e-6, -2.0, 5.0]),
            Scale::apart(50.0),
        );
        assert_eq!((test.directions, test.unknowns), (1, 2));
        assert!(
            (test.mean_square - 4.0).abs() < 1.0e-9 && !test.convention_differs,
            "{test:?}"
        );
        let other = root.test(
            &DVector::from_column_slice(&[2.0e-6, 2.0, 0.0]),
            Scale::apart(50.0),
        );
        assert!(
            other.convention_differs && other.mean_square < 1.0e-9,
            "{other:?}"
        );
    }
}
