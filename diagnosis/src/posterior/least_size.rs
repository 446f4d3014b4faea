//! The least size worth naming, as a prior and not as a threshold afterwards.
//!
//! A set says that each of its effects does more than so many whitened squares on this motion. The prior of its coefficients is cut off
//! below (a truncated, and so a non-local, prior: Rossell and Telesca 2017, J. Am. Stat. Assoc. 112, 254). The evidence of a cut prior is
//! that of the whole one times the probability of what stays after the data, over the same before them.

use super::evidence::Fitted;
use super::reduced::Reduced;
use super::scale;

/// Share of the noise, in squares over all rows, below which an effect is not worth a name: it changes the rms of what is left by a
/// hundredth, which is what the rms of twelve thousand rows scatters by (their root, halved).
const LEAST_SHARE_OF_NOISE: f64 = 0.02;

/// What shows on a motion with less than this probability before the data gains no more by being cut off: one in twenty, below which the
/// prior's own tail is not known.
const SELDOM: f64 = 0.05;

/// Whitened squares below which no effect is worth a name.
pub fn least_squares(rows: f64) -> f64 {
    LEAST_SHARE_OF_NOISE * rows
}

/// What each effect of a set does on this motion, in whitened squares over the noise, the baseline projected out.
pub fn powers(reduced: &Reduced, fitted: &Fitted, noise: f64) -> Vec<f64> {
    let each = parts(reduced, fitted);
    each.into_iter()
        .map(|(columns, at)| {
            let own = fitted.given.coefficients.rows(at, columns.len());
            own.dot(&(reduced.square(&columns) * own)).max(0.0) / noise
        })
        .collect()
}

/// Logarithm of what cutting the priors off adds to the evidence of a set. `inexactness` is, for each effect, the share of its amplitude
/// that its form may lack: a companion must do more than the others may lack.
pub fn log_ratio(
    reduced: &Reduced,
    fitted: &Fitted,
    powers: &[f64],
    inexactness: &[f64],
    noise: f64,
) -> f64 {
    let lacking: Vec<f64> = powers
        .iter()
        .zip(inexactness)
        .map(|(q, e)| e * e * q)
        .collect();
    let whole: f64 = lacking.iter().sum();
    let parts = parts(reduced, fitted);
    let one = |(k, (columns, at)): (usize, &(Vec<usize>, usize))| {
        let least = least_squares(reduced.rows) + whole - lacking[k];
        let products = reduced.square(columns) / noise;
        let own = fitted.given.coefficients.rows(*at, columns.len());
        let slope = &products * own;
        // The root of the squares scatters by about one, and more where another effect can take them.
        let inverse = fitted.given.factor_inverse.columns(*at, columns.len());
        let deviation = ((inverse * slope).norm_squared() / powers[k].max(f64::MIN_POSITIVE))
            .sqrt()
            .max(1.0);
        let after = log_normal((powers[k].sqrt() - least.sqrt()) / deviation);
        let before = scale::prior_beyond(least / products.trace().max(f64::MIN_POSITIVE));
        after - before.max(SELDOM).ln()
    };
    parts.iter().enumerate().map(one).sum()
}

/// Columns of each effect of a set, and the place of the first among the set's.
fn parts(reduced: &Reduced, fitted: &Fitted) -> Vec<(Vec<usize>, usize)> {
    let mut at = 0;
    let part = |b: &usize| {
        let columns: Vec<usize> = reduced.blocks[*b].clone().collect();
        at += columns.len();
        let first = at - columns.len();
        (columns, first)
    };
    fitted.set.iter().map(part).collect()
}

/// From so many standard deviations below on, the probability of a normal number is that of its tail's first term, to 4 % of it.
const TAIL_FROM: f64 = -5.0;

/// Logarithm of the probability that a normal number of unit deviation is below a value.
pub fn log_normal(value: f64) -> f64 {
    if value < TAIL_FROM {
        -0.5 * value * value - (-value * std::f64::consts::TAU.sqrt()).ln()
    } else {
        (0.5 * libm::erfc(-value * std::f64::consts::FRAC_1_SQRT_2)).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posterior::evidence::fitted;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    #[test]
    fn normal_probabilities_are_those_of_tables() {
        for (value, wanted) in [
            (0.0, 0.5_f64),
            (1.96, 0.975),
            (-1.645, 0.05),
            (-6.0, 9.866e-10),
        ] {
            assert!((log_normal(value) - wanted.ln()).abs() < 0.03, "{value}");
        }
    }

    /// What hardly shows counts against a set that holds it, however certain it is; what shows does not. Beside a large effect that is known
    /// to a tenth, a companion must be larger than what that lacks.
    #[test]
    fn a_trifle_counts_against_a_set() {
        let ratio = |companion: f64, inexactness: f64| {
            let blocks = [("large", &[1.0][..]), ("small", &[1.0])];
            let problem = SyntheticProblem::new(&blocks, &|rng| {
                let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
                vec![1.0, one, other, 3.0 * one + companion * other + noise]
            });
            let reduced = problem.reduced(&[1, 2]);
            let set = fitted(&reduced, &[0, 1], &[0.0, 0.0], 1.0).unwrap();
            let powers = powers(&reduced, &set, 1.0);
            assert!((powers[0] / reduced.rows - 9.0).abs() < 0.9, "{powers:?}");
            log_ratio(&reduced, &set, &powers, &[inexactness, 0.0], 1.0)
        };
        // 2000 rows: 0.03 of an amplitude is 2 squares, 0.3 is 180, and a tenth of 3 is 180 as well.
        assert!(ratio(0.03, 0.0) < -3.0, "{}", ratio(0.03, 0.0));
        assert!(ratio(0.3, 0.0) > -0.1);
        assert!(ratio(0.1, 0.1) < -10.0);
        assert!(ratio(0.6, 0.1) > -0.1);
    }
}
