//! What lateral terms make of the difference of two calibrations.
//!
//! A calibration by the parity does not fit how a segment's output depends on the tooth phase across it. What it leaves of that is
//! no noise: it is a sum of waves that are known, with amplitudes c that are not, but are the same in both calibrations of a courier. With
//! `R = -(V^T V)^-1 V^T L`, V the rows of a fit and L the waves in the parity at the same poses, coefficients are off by `R c`, so that their
//! difference is `(R_2 - R_1) c`. What is common to both is gone; the rest follows from the poses, which are known. Over all
//! draws of poses its covariance is nearly that of noise which leaves as much in the parity. At these poses it is another, and it has other directions.
//!
//! With amplitudes that are normal beforehand the mean square of the difference, over what the parity left of the same waves, is a quotient of
//! two quadratic forms of them, `c^T A c / c^T M c`, beside noise in both. Mean and variance of each form are `tr A` and `2 tr A^2`, the covariance of
//! both is `2 tr A M`, and those of the quotient follow to second order (delta method).

use crate::distribution::{freedom_by_variance, relative_variance};
use crate::significance::Root;
use courier_sensor::equations::{PARITY_SIGN, lateral_arguments};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Own order, order across, and how large a wave is beside the others, µm. A prior: the one that the diagnosis has for them
/// (`effects/src/lateral_dependence.rs`). How large they are together is of no account here.
const WAVES: [(f64, f64, f64); 7] = [
    (0.0, 1.0, 4.0),
    (0.0, 2.0, 2.0),
    (0.0, 3.0, 0.5),
    (1.0, 1.0, 0.7),
    (1.0, -1.0, 0.7),
    (2.0, 1.0, 0.7),
    (2.0, -1.0, 0.7),
];
/// Waves of all segments, of each its sine and cosine.
pub const COUNT: usize = 2 * SEGMENTS * WAVES.len();
/// Shares of lateral terms in the variance that a parity is left with: so many, even from none to all. A prior: they are "roughly the same size as the
/// residual errors" (paper, 3.1.2), beside teeth that are as large (section 4); how much exactly is not known, so any share is as likely. Derived from
/// the midpoint rule: means of fourth powers to a percent.
const SHARES: i32 = 10;

/// The waves in the parity at places of the segments along themselves, metres, and an angle.
pub fn waves(geometry: &Geometry, places_m: [f64; SEGMENTS], theta_rad: f64) -> [f64; COUNT] {
    let middle = [0, 1].map(|k| 0.5 * (places_m[k] + places_m[k + 2]));
    let across_m = lateral_arguments(middle, theta_rad, f64::from(geometry.lateral_m));
    let per_m = TAU / f64::from(geometry.pitch_m);
    let mut row = [0.0; COUNT];
    let (pairs, _) = row.as_chunks_mut::<2>();
    for (segment, pairs) in pairs.chunks_mut(WAVES.len()).enumerate() {
        for (pair, (own, across, size)) in pairs.iter_mut().zip(WAVES) {
            let phase = per_m * (own * places_m[segment] + across * across_m[segment]);
            let (sine, cosine) = phase.sin_cos();
            *pair = [sine, cosine].map(|u| f64::from(PARITY_SIGN[segment]) * size * u);
        }
    }
    row
}

/// What waves of unit amplitude in one calibration make.
#[derive(Clone, Debug, PartialEq)]
pub struct Lateral {
    /// By how much the unknowns are off, a column for each wave.
    pub response: DMatrix<f64>,
    /// What the parity is left with: products of the waves, as shares of the square of the calibration's noise in metres.
    pub left: DMatrix<f64>,
}

impl Lateral {
    /// For unit noise, by the inverse of the products of a fit's rows, the offset's last; of poses that were fitted and of those held out the row and the
    /// waves. `spread`: what a held-out parity's variance is with the fit's own error.
    pub fn of(
        inverse: &DMatrix<f64>,
        fitted: &[(DVector<f64>, DVector<f64>)],
        held_out: &[(DVector<f64>, DVector<f64>)],
        spread: f64,
    ) -> Self {
        let mut products = DMatrix::zeros(inverse.nrows(), COUNT);
        for (row, waves) in fitted {
            products.ger(1.0, row, waves, 1.0);
        }
        let response = -(inverse * products);
        let rest: Vec<DVector<f64>> = held_out
            .iter()
            .map(|(row, waves)| waves + response.tr_mul(row))
            .collect();
        let mean = rest.iter().sum::<DVector<f64>>() / rest.len() as f64;
        let share = 1.0 / (spread * (rest.len() as f64 - 1.0));
        let mut left = DMatrix::zeros(COUNT, COUNT);
        for rest in rest {
            let rest = rest - &mean;
            left.ger(share, &rest, &rest, 1.0);
        }
        Self {
            response: response.rows(0, response.nrows() - 1).into_owned(),
            left,
        }
    }

    /// Beside noise of a size in metres.
    #[must_use]
    pub fn beside(self, noise_m: f64) -> Self {
        Self {
            left: self.left / (noise_m * noise_m),
            ..self
        }
    }

    /// For a list of unknowns that are at these places among those that it has, or nowhere: then they are not off.
    #[must_use]
    pub fn of_unknowns(&self, places: &[Option<usize>]) -> Self {
        let element = |row: usize, wave| places[row].map_or(0.0, |k| self.response[(k, wave)]);
        Self {
            response: DMatrix::from_fn(places.len(), COUNT, element),
            left: self.left.clone(),
        }
    }
}

/// How the mean square of a difference differs from that by noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Its mean, where noise alone has one.
    pub mean: f64,
    /// Degrees of freedom of its scale.
    pub freedom: f64,
}

/// Of the difference of two calibrations with a covariance and degrees of freedom by noise alone; of each its share in the covariance. No more
/// is taken for lateral terms than both were left with.
pub fn moments(covariance: &DMatrix<f64>, freedom: f64, sides: [(f64, &Lateral); 2]) -> Moments {
    let root = Root::of(covariance);
    let directions = root.rank() as f64;
    let [one, two] = sides.map(|(_, side)| side);
    let largest = one.left.trace().max(two.left.trace());
    let white = &root.inverse * (&two.response - &one.response);
    let forms = white.transpose() * white / (largest * directions);
    let left = sides
        .map(|(share, side)| &side.left * share)
        .into_iter()
        .sum::<DMatrix<f64>>()
        / largest;
    let (all, of_left) = (forms.trace(), left.trace());
    // Fisher's F has no variance below that.
    let has_variance = freedom > 4.0;
    if !(all > 0.0 && of_left > 0.0 && has_variance) {
        return Moments { mean: 1.0, freedom };
    }
    let products = |a: &DMatrix<f64>, b: &DMatrix<f64>| 2.0 * a.dot(b) / (a.trace() * b.trace());
    let quotient = Quotient {
        mean: all / of_left,
        variance: products(&forms, &forms),
        of_scale: products(&left, &left),
        together: products(&forms, &left),
        of_noise: 2.0 / directions,
    };
    let (mut mean, mut square) = (0.0, 0.0);
    for step in 0..SHARES {
        let share = (f64::from(step) + 0.5) / f64::from(SHARES);
        let (of_share, variance) = quotient.moments(share * of_left);
        mean += of_share / f64::from(SHARES);
        square += (variance + of_share * of_share) / f64::from(SHARES);
    }
    let more = square / (mean * mean) - 1.0 - quotient.of_noise;
    let variance = relative_variance(directions, freedom) + more;
    Moments {
        mean,
        freedom: freedom_by_variance(directions, variance),
    }
}

/// The mean square of what lateral terms make of the difference over the mean of what they are left with: relative moments, over the squares of their means.
struct Quotient {
    /// Quotient of the means.
    mean: f64,
    /// Variance of what is divided.
    variance: f64,
    /// Variance of what it is divided by.
    of_scale: f64,
    /// Covariance of both.
    together: f64,
    /// Variance of a mean square by noise.
    of_noise: f64,
}

impl Quotient {
    /// Mean and variance where lateral terms have this share beside noise, whose scale is known.
    fn moments(&self, share: f64) -> (f64, f64) {
        let noise = 1.0 - share;
        let divided = noise + share * self.mean;
        let variance = self.of_noise * noise * (noise + 2.0 * share * self.mean)
            + (share * self.mean).powi(2) * self.variance;
        let scale = share * share * self.of_scale;
        let together = share * share * self.mean * self.together;
        (
            divided * (1.0 + scale) - together,
            variance + divided * (divided * scale - 2.0 * together),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::relative_variance;
    use effects::identity::Identity;
    use effects::sensor::BasisInputs;
    use nalgebra::SymmetricEigen;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal, StandardUniform};

    /// The prior is that of the diagnosis: its waves of one segment, each with its size.
    #[test]
    fn waves_are_those_of_the_diagnosis() {
        let inputs = BasisInputs {
            segments: [true, false, false, false],
            lateral: true,
            ..BasisInputs::default()
        };
        let sides = effects::sensor_sides();
        let side = sides
            .iter()
            .find(|side| side.name() == "lateral_dependence");
        let mut found = Vec::new();
        for regressor in side.unwrap().regressors(&inputs) {
            let Some(Identity::Wave(wave)) = regressor.identity else {
                panic!("{}: found no wave", regressor.name)
            };
            let orders = (wave.own_order as f64, f64::from(wave.lateral_order));
            found.push((orders.0, orders.1, 1.0e6 * regressor.size_m));
        }
        // Of each its sine and cosine.
        assert_eq!(found.len(), 2 * WAVES.len());
        for (pair, wave) in found.as_chunks::<2>().0.iter().zip(WAVES) {
            for found in pair {
                assert_eq!((found.0, found.1), (wave.0, wave.1));
                assert!((found.2 - wave.2).abs() < 1.0e-9, "{found:?} {wave:?}");
            }
        }
    }

    /// Random rows of some unknowns and an offset, and waves that go with them in part.
    fn rows(
        rng: &mut ChaCha8Rng,
        count: usize,
        unknowns: usize,
    ) -> Vec<(DVector<f64>, DVector<f64>)> {
        let mut normal = |n| DVector::<f64>::from_fn(n, |_, _| StandardNormal.sample(rng));
        let mut row = || {
            let mut row = normal(unknowns + 1);
            row[unknowns] = 1.0;
            let mut waves = normal(COUNT);
            (0..unknowns)
                .for_each(|k| waves[k] = 0.5 * (waves[k] + row[k] * row[(k + 1) % unknowns]));
            (row, waves)
        };
        (0..count).map(|_| row()).collect()
    }

    fn inverse(rows: &[(DVector<f64>, DVector<f64>)]) -> DMatrix<f64> {
        let products = rows.iter().map(|(row, _)| row * row.transpose());
        products.sum::<DMatrix<f64>>().try_inverse().unwrap()
    }

    /// Amplitudes, fitted by least squares; and what held-out rows are left with.
    #[test]
    fn a_fit_is_off_by_its_response() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (fitted, held_out) = (rows(&mut rng, 100, 6), rows(&mut rng, 40, 6));
        let amplitudes = DVector::<f64>::from_fn(COUNT, |_, _| StandardNormal.sample(&mut rng));
        let all = DMatrix::from_fn(100, 7, |i, k| fitted[i].0[k]);
        let seen = DVector::from_fn(100, |i, _| fitted[i].1.dot(&amplitudes));
        let found = -all.svd(true, true).solve(&seen, 1.0e-12).unwrap();
        let of = Lateral::of(&inverse(&fitted), &fitted, &held_out, 1.5);
        let told = &of.response * &amplitudes;
        assert!((told - found.rows(0, 6)).amax() < 1.0e-9);
        let rest: Vec<f64> = held_out
            .iter()
            .map(|(row, waves)| waves.dot(&amplitudes) + row.dot(&found))
            .collect();
        let mean = rest.iter().sum::<f64>() / 40.0;
        let wanted = rest.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 39.0 / 1.5;
        let left = amplitudes.dot(&(&of.left * &amplitudes));
        assert!((left / wanted - 1.0).abs() < 1.0e-9, "{left} {wanted}");
    }

    /// Against drawn amplitudes, noise, and shares of both: mean and variance of the mean square over what was left.
    #[test]
    fn moments_are_those_of_drawn_amplitudes() {
        const DRAWS: usize = 20_000;
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let unknowns = 12;
        let mut covariance = DMatrix::zeros(unknowns, unknowns);
        let mut side = |count| {
            let (fitted, held_out) = (
                rows(&mut rng, count, unknowns),
                rows(&mut rng, 60, unknowns),
            );
            let inverse = inverse(&fitted);
            covariance += inverse.view((0, 0), (unknowns, unknowns));
            Lateral::of(&inverse, &fitted, &held_out, 1.0)
        };
        let sides = [side(30), side(30)];
        let [one, two] = &sides;
        let found = moments(&covariance, f64::INFINITY, [(0.5, one), (0.5, two)]);
        let SymmetricEigen {
            eigenvectors,
            eigenvalues,
        } = covariance.clone().symmetric_eigen();
        let white = DMatrix::from_diagonal(&eigenvalues.map(|v| v.sqrt().recip()))
            * eigenvectors.transpose();
        let off = white * (&two.response - &one.response);
        let left = 0.5 * (&one.left + &two.left);
        let size = left.trace();
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..DRAWS {
            let share: f64 = StandardUniform.sample(&mut rng);
            let mut normal = |n| DVector::<f64>::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
            let amplitudes = normal(COUNT) / size.sqrt();
            let values =
                (1.0 - share).sqrt() * normal(unknowns) + share.sqrt() * (&off * &amplitudes);
            let scale = 1.0 - share + share * amplitudes.dot(&(&left * &amplitudes));
            let square = values.norm_squared() / unknowns as f64 / scale;
            sum += square;
            squares += square * square;
        }
        let mean = sum / DRAWS as f64;
        let variance = squares / DRAWS as f64 / (mean * mean) - 1.0;
        let wanted = relative_variance(unknowns as f64, found.freedom);
        let deviation = (variance / DRAWS as f64).sqrt();
        println!(
            "mean {mean:.4}, {:.4} told; variance {variance:.4}, {wanted:.4} told",
            found.mean
        );
        assert!(
            (mean / found.mean - 1.0).abs() < 4.0 * deviation + 0.01,
            "{mean} {found:?}"
        );
        assert!(
            (variance / wanted - 1.0).abs() < 0.05,
            "{variance} {wanted}"
        );
    }
}
