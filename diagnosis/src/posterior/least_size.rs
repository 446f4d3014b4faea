//! The least size worth naming, as a prior and not as a threshold afterwards.
//!
//! A set says that each of its effects does more than so many whitened squares on this motion which the others of the set cannot do. The
//! prior of its coefficients is cut off below (a truncated, and so a non-local, prior: Rossell and Telesca 2017, J. Am. Stat. Assoc. 112,
//! 254). The evidence of a cut prior is that of the whole one times the probability of what stays after the data, over the same before
//! them.

use super::eliminated::Eliminated;
use super::evidence::Fitted;
use super::problem::Problem;
use super::reduced::Reduced;
use super::scale;
use nalgebra::DVector;

/// Share of the noise, in squares over all rows, below which an effect is not worth a name: it changes the rms of what is left by
/// a hundredth. Derived from the scatter of an rms of `n` rows, `1/√(2n)`, which is two thirds of that for twelve thousand.
const LEAST_SHARE_OF_NOISE: f64 = 0.02;

/// What shows on a motion with less than this probability before the data gains no more by being cut off. A prior: below one in twenty
/// the prior's own tail is a guess.
const SELDOM: f64 = 0.05;

/// Whitened squares below which no effect is worth a name.
pub fn least_squares(rows: f64) -> f64 {
    LEAST_SHARE_OF_NOISE * rows
}

/// What each effect of a set does on this motion, in whitened squares over the noise, the baseline projected out.
pub fn powers(reduced: &Reduced, fitted: &Fitted, noise: f64) -> Vec<f64> {
    let each = parts(reduced, &fitted.set);
    each.into_iter()
        .map(|(columns, at)| {
            let own = fitted.given.coefficients.rows(at, columns.len());
            own.dot(&(reduced.square(&columns) * own)).max(0.0) / noise
        })
        .collect()
}

/// Whitened squares that the forms of some effects may lack, told by what each does alone and by the share of its amplitude that its form
/// may lack, beside what they explain together: effects that nearly cancel do much, and may lack no more than the least exact of them
/// would of that.
pub fn lacking(explained: f64, each: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for (power, inexactness) in each {
        sum += power * inexactness * inexactness;
        largest = largest.max(inexactness * inexactness);
    }
    sum.min(explained.max(0.0) * largest)
}

/// A set at known sizes and noise, of which it is asked what each of its effects does that the others cannot.
pub struct SetAtSizes<'a> {
    /// Normal equations.
    pub reduced: &'a Reduced,
    /// Blocks.
    pub set: &'a [usize],
    /// Logarithm of each block's variance over the stated one.
    pub log_variances: &'a [f64],
    /// Variance of the noise.
    pub noise: f64,
}

/// What an effect does that the others of its set cannot do, by its own amounts.
pub struct OwnPower {
    /// Whitened squares over the noise.
    pub power: f64,
    /// Half the slope of these squares by the amounts.
    pub slope: DVector<f64>,
    /// What amounts of the stated size do in the mean.
    pub typical: f64,
}

impl SetAtSizes<'_> {
    /// What one of the effects does by some amounts, by its precision by the data alone, the others fitted with their priors. None where
    /// their equations cannot be solved. Cost: that of the evidence of the others.
    pub fn own_power(&self, which: usize, amounts: &DVector<f64>) -> Option<OwnPower> {
        let others = (0..self.set.len()).filter(|k| *k != which);
        let (set, sizes): (Vec<usize>, Vec<f64>) =
            others.map(|k| (self.set[k], self.log_variances[k])).unzip();
        let (own, rest) = (
            self.reduced.columns(&self.set[which..=which]),
            self.reduced.columns(&set),
        );
        let across = self.reduced.across(&rest, &own) / self.noise;
        let half = Eliminated::new(self.reduced, &set, &sizes, self.noise)?.half(&across);
        let normal = self.reduced.square(&own) / self.noise;
        let slope = &normal * amounts - half.tr_mul(&(&half * amounts));
        Some(OwnPower {
            power: amounts.dot(&slope).max(0.0),
            typical: (normal.trace() - half.norm_squared()).max(f64::MIN_POSITIVE),
            slope,
        })
    }
}

/// What an effect of a set does that the others cannot, beside what is asked of it.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// Whitened squares over the noise (6a).
    pub power: f64,
    /// What the forms of the others may lack of them, and what is not worth a name.
    pub may_be_lacking: f64,
    /// Logarithm of what cutting the effect's prior off adds to the evidence.
    pub log_least: f64,
    /// Logarithm of the probability, after the data, that it does no more than what is not worth a name.
    pub log_trifle: f64,
}

/// Logarithm of the probability that so many squares over the noise, as they were found, are truly no more than what is not worth a name:
/// their root scatters by about one.
pub fn log_trifle(squares: f64, rows: f64) -> f64 {
    log_normal(least_squares(rows).sqrt() - squares.max(0.0).sqrt())
}

/// What each effect does of a set that explains so many whitened squares over the noise. None where its equations cannot be solved.
/// `each` is, for each effect, what it does alone and the share of its amplitude that its form may lack. A companion must do more than the others may lack, one that makes lines in the spectrum more
/// than those others may that make some as well.
/// It need not where it takes so large a share of what is left without it that so few columns would do that only by chance.
pub fn shares(
    problem: &Problem,
    fitted: &Fitted,
    explained: f64,
    each: &[(f64, f64)],
) -> Option<Vec<Share>> {
    let Problem { reduced, noise, .. } = *problem;
    let set_at_sizes = SetAtSizes {
        reduced,
        set: &fitted.set,
        log_variances: &fitted.log_variances,
        noise,
    };
    let parts = parts(reduced, &fitted.set);
    let all = fitted.given.coefficients.len();
    let one = |(k, (columns, at)): (usize, &(Vec<usize>, usize))| {
        let amounts = fitted.given.coefficients.rows(*at, columns.len());
        let OwnPower {
            power,
            slope,
            typical,
        } = set_at_sizes.own_power(k, &amounts.into_owned())?;
        let makes_lines = problem.of_lines.contains(&fitted.set[k]);
        let others = (0..each.len()).filter(|other| *other != k);
        let lacking = lacking(
            explained - power,
            others.map(|other| match each[other] {
                (power, share) if makes_lines => {
                    (power, problem.in_lines(fitted.set[other], share))
                }
                each => each,
            }),
        );
        let least = least_squares(reduced.rows);
        // The root of the squares scatters by about one, and more where the prior tells part of the coefficients.
        let mut whole = DVector::zeros(all);
        whole.rows_mut(*at, columns.len()).copy_from(&slope);
        let scattered = fitted.given.eliminated.solve(&whole);
        let variance = scattered.dot(&whole) / power.max(f64::MIN_POSITIVE);
        let deviation = variance.sqrt().max(1.0);
        let above = (power.sqrt() - least.sqrt()) / deviation;
        let cut = scale::prior_beyond(least / typical).max(SELDOM).ln();
        Some(Share {
            power,
            may_be_lacking: least + lacking,
            log_least: log_normal(above) - cut,
            log_trifle: log_normal(-above),
        })
    };
    parts.iter().enumerate().map(one).collect()
}

/// Columns of each effect of a set, and the place of the first among the set's.
fn parts(reduced: &Reduced, set: &[usize]) -> Vec<(Vec<usize>, usize)> {
    let mut at = 0;
    let part = |b: &usize| {
        let columns: Vec<usize> = reduced.blocks[*b].clone().collect();
        at += columns.len();
        let first = at - columns.len();
        (columns, first)
    };
    set.iter().map(part).collect()
}

/// From so many standard deviations below on, the probability of a normal number is that of its tail's first term, to 4 % of it.
/// Derived from Mill's ratio: the second term is 1/z² of the first, 4 % at five.
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

    /// What hardly shows counts against a set that holds it, however certain it is; what shows does not.
    #[test]
    fn a_trifle_counts_against_a_set() {
        let ratio = |companion: f64| {
            let blocks = [("large", &[1.0][..]), ("small", &[1.0])];
            let problem = SyntheticProblem::new(&blocks, &|rng| {
                let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
                vec![1.0, one, other, 3.0 * one + companion * other + noise]
            });
            let reduced = problem.reduced(&[1, 2]);
            let set = fitted(&reduced, &[0, 1], &[0.0, 0.0], 1.0).unwrap();
            let powers = powers(&reduced, &set, 1.0);
            assert!((powers[0] / reduced.rows - 9.0).abs() < 0.9, "{powers:?}");
            let explained = reduced.squares - set.given.squares;
            let problem = Problem::of_unit_noise(&reduced, &[], 0.0);
            let each = [(powers[0], 0.1), (powers[1], 0.0)];
            let shares = shares(&problem, &set, explained, &each).unwrap();
            shares.iter().map(|share| share.log_least).sum::<f64>()
        };
        // 2000 rows: 0.03 of an amplitude is 2 squares, 0.3 is 180.
        assert!(ratio(0.03) < -3.0, "{}", ratio(0.03));
        assert!(ratio(0.3) > -0.1);
    }
}
