//! The noise, integrated out: near the stated one, or louder by a factor that nothing is known of.

use super::evidence::Fitted;
use super::reduced::Reduced;
use crate::algebra::statistics::NORMAL_97_5;

/// Standard deviation of the logarithm of the noise's variance about the stated one: a recording whose rms is within 5 % of the
/// stated noise shows no gap (`docs/reading-a-diagnosis.md`), which is two standard deviations of the rms, and a variance's is
/// twice that. A prior: `docs/reading-a-diagnosis.md` states that 5 %.
pub(crate) const STATED_TO: f64 = 0.05;
/// Loudest noise that is looked for, as a logarithm of the variance. A prior: thirty times the stated noise is more than readings
/// have (2 ln 30 = 6.8).
pub(crate) const LOUDEST: f64 = 6.8;
/// Standard deviations by which noise may be quieter than stated. Derived from [`STATED_TO`]: two of them are the 5 % of the rms
/// within which a recording shows no gap.
const QUIETER: f64 = 2.0;
/// Points of the grid to a standard deviation: many, since the density of louder noise may be cut off where it is steep. Derived
/// from the cut: a sum that begins between two points is off by half a step, 3 % of a deviation.
const POINTS: f64 = 16.0;

/// Rms of noise over the stated one, as quiet as stated noise may be.
pub(crate) fn quietest_rms() -> f64 {
    (-0.5 * QUIETER * STATED_TO).exp()
}

/// What a set leaves, and how its density goes with the noise.
#[derive(Clone, Copy, Debug)]
pub struct Left {
    /// Logarithm of the variance of the noise at which the set was fitted, over the stated one.
    pub log_noise: f64,
    /// Logarithm of the density at that noise, integrated over the sizes.
    pub log_density: f64,
    /// Whitened squares over the stated noise that the set leaves.
    pub squares: f64,
    /// Those among them, in the mean, that the fit adds to the noise, since its columns are formed of noisy readings.
    pub allowance: f64,
    /// Rows less the coefficients that they tell.
    pub degrees: f64,
}

impl Left {
    /// Of a set, fitted at a variance of the noise.
    pub fn of(reduced: &Reduced, fitted: &Fitted, noise: f64, stated: f64) -> Self {
        let list = reduced.columns(&fitted.set);
        let rebuilt = reduced.log_rebuilt(&list, &fitted.given.coefficients, noise / stated, noise);
        Self {
            log_noise: (noise / stated).ln(),
            log_density: fitted.given.log_density + fitted.log_widths + rebuilt,
            squares: fitted.given.squares / stated,
            allowance: fitted.allowance / stated,
            degrees: reduced.rows - reduced.baseline as f64 - fitted.given.told,
        }
        .no_less_than_noise()
    }

    /// The same with what noise alone leaves, as quiet as it may be, where it leaves less: no set gains by that. A set leaves less, even less
    /// than nothing, where the noise is stated far too loud: what columns and target have in common by the stated noise is then taken off and is
    /// not there.
    pub fn no_less_than_noise(self) -> Self {
        let scatter = (2.0 * self.degrees.max(0.0)).sqrt();
        let quietest = (-QUIETER * STATED_TO).exp();
        let least = quietest * (self.degrees - QUIETER * scatter).max(0.0);
        let missing = (least - self.squares).max(0.0);
        Self {
            squares: self.squares + missing,
            log_density: self.log_density - 0.5 * missing * (-self.log_noise).exp(),
            ..self
        }
    }
}

/// The noise under a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseScale {
    /// Logarithm of the likeliest variance over the stated one.
    pub log_variance: f64,
    /// Logarithm of the evidence, by noise near the stated one.
    pub stated: f64,
    /// The same, by noise that is louder by any factor.
    pub louder: f64,
}

impl NoiseScale {
    /// The same of those kinds of noise alone that another has.
    pub fn only_as(self, other: &Self) -> Self {
        let kept = |own: f64, other: f64| if other.is_finite() { own } else { other };
        Self {
            stated: kept(self.stated, other.stated),
            louder: kept(self.louder, other.louder),
            ..self
        }
    }
}

/// Integrates over the noise. The coefficients are taken to stay as the noise changes, and each that the data tell takes a row: exact to
/// first order in the share of the data that the prior tells. A fit whose columns carry noise leaves more than the target's own
/// (the likelihood of errors in variables: Fuller 1987). `inexact` is the share of the noise, in squares, that the set's own effects
/// may leave, with 95 % probability, because their forms are not exact: the noise seems so much louder.
pub fn integrate(left: &Left, inexact: f64) -> NoiseScale {
    let degrees = left.degrees.max(1.0);
    // Noise of the columns is there beside that of the target, and costs as much as any other noise.
    let added = left.allowance.max(0.0) / degrees;
    // The density where it is known, less how it goes with the variance there.
    let there = 0.5 * (degrees * left.log_noise + left.squares * (-left.log_noise).exp());
    let constant = left.log_density + there;
    let likelihood = |at: f64| {
        let variance = at.exp() + added;
        constant - 0.5 * degrees * variance.ln() - 0.5 * left.squares / variance
    };
    let near = STATED_TO.hypot(inexact.ln_1p() / NORMAL_97_5);
    let gauss = |at: f64| -0.5 * (at / near).powi(2) - (near * std::f64::consts::TAU.sqrt()).ln();
    let flat = |at: f64| {
        if (0.0..LOUDEST).contains(&at) {
            -LOUDEST.ln()
        } else {
            f64::NEG_INFINITY
        }
    };
    let integral = |precision: f64, log_prior: &dyn Fn(f64) -> f64| {
        let (middle, deviation) = top(left, added, precision);
        let step = deviation / POINTS;
        let points = (-SIDE..=SIDE).map(|k| middle + step * f64::from(k));
        (
            middle,
            log_sum(points.map(|at| likelihood(at) + log_prior(at))) + step.ln(),
        )
    };
    let (log_variance, louder) = integral(0.0, &flat);
    NoiseScale {
        log_variance,
        louder,
        stated: integral(near.powi(-2), &gauss).1,
    }
}

/// Points of the grid to either side: six standard deviations. Derived from the normal tail: two in a thousand million lie
/// beyond.
const SIDE: i32 = 96;

/// Where the density of the logarithm of the target's own variance is largest, and its standard deviation there: `added` is the variance
/// that is there besides, and the logarithm has a normal prior of this precision about zero. Fisher's scoring.
fn top(left: &Left, added: f64, precision: f64) -> (f64, f64) {
    let degrees = left.degrees.max(1.0);
    let share = |at: f64| at.exp() / (at.exp() + added);
    let bend = |at: f64| (0.5 * degrees * share(at).powi(2) + precision).max(f64::MIN_POSITIVE);
    let mut at = 0.0_f64;
    for _ in 0..STEPS {
        let squares = left.squares / (at.exp() + added);
        let slope = 0.5 * (squares - degrees) * share(at) - precision * at;
        at = (at + (slope / bend(at)).clamp(-1.0, 1.0)).clamp(-LOUDEST, LOUDEST);
    }
    (at, bend(at).sqrt().recip())
}

/// Steps of that: more than the largest noise is away, a step being at most one. Derived from the largest: `LOUDEST` is 6.8, and
/// half of the steps would do.
const STEPS: usize = 16;

/// Logarithm of a sum of numbers that are told by their logarithms.
pub fn log_sum(logarithms: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = logarithms.collect();
    let top = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + all.iter().map(|v| (v - top).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posterior::evidence::{fitted, given};
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// Against the exact density at each point of a fine grid over the noise: the coefficients stay, to first order.
    /// A set that leaves less than noise as quiet as it may be, or less than nothing, is told as one that leaves that noise.
    #[test]
    fn no_set_leaves_less_than_noise() {
        let of = |squares: f64| Left {
            log_noise: 0.0,
            log_density: -0.5 * squares,
            squares,
            allowance: 0.0,
            degrees: 1.0e4,
        };
        let least = 0.904_837 * (1.0e4 - 2.0 * 2.0e4_f64.sqrt());
        for squares in [-3.0e3, 2.0e3] {
            let told = of(squares).no_less_than_noise();
            assert!((told.squares - least).abs() < 1.0, "{told:?}");
            assert!((told.log_density + 0.5 * least).abs() < 0.5, "{told:?}");
        }
        let usual = of(9.7e3).no_less_than_noise();
        assert_eq!((usual.squares, usual.log_density), (9.7e3, -4850.0));
    }

    #[test]
    fn the_integral_is_that_of_the_exact_densities() {
        for louder in [1.0, 1.2, 3.0] {
            let problem = SyntheticProblem::new(&[("block", &[1.0, 1.0][..])], &|rng| {
                let (one, other, noise) = (normal(rng), normal(rng), louder * normal(rng));
                vec![1.0, one, other, 0.2 * one + noise]
            });
            let reduced = problem.reduced(&[1]);
            let set = fitted(&reduced, &[0], &[0.0], 1.0).unwrap();
            let found = integrate(&Left::of(&reduced, &set, 1.0, 1.0), 0.0);
            let step = 0.002;
            let density = |at: f64| {
                given(&reduced, &[0], &set.log_variances, at.exp())
                    .unwrap()
                    .log_density
                    + set.log_widths
            };
            let grid: Vec<f64> = (-200..1500).map(|k| step * f64::from(k)).collect();
            let near = |at: f64| {
                -0.5 * (at / STATED_TO).powi(2) - (STATED_TO * std::f64::consts::TAU.sqrt()).ln()
            };
            let stated = log_sum(grid.iter().map(|at| density(*at) + near(*at))) + step.ln();
            let any = grid.iter().filter(|at| **at >= 0.0);
            let any = log_sum(any.map(|at| density(*at) - LOUDEST.ln())) + step.ln();
            assert!(
                (found.stated - stated).abs() < 0.2,
                "{louder}: {found:?} {stated}"
            );
            assert!(
                (found.louder - any).abs() < 0.2,
                "{louder}: {found:?} {any}"
            );
            // Noise that is as stated is told so, and noise that is not is not.
            assert_eq!(found.stated > found.louder, louder == 1.0, "{found:?}");
        }
    }

    /// Three times as much noise in the columns as in the target is no louder noise, and costs what four times the noise costs.
    #[test]
    fn noise_of_the_columns_costs_as_any_other() {
        let left = |squares: f64, allowance: f64| Left {
            log_noise: 0.0,
            log_density: -0.5 * squares,
            squares,
            allowance,
            degrees: 1000.0,
        };
        let plain = integrate(&left(1000.0, 0.0), 0.0);
        let carried = integrate(&left(4000.0, 3000.0), 0.0);
        let cost = plain.stated - carried.stated;
        assert!((cost - 500.0 * 4.0_f64.ln()).abs() < 1.0, "{cost}");
        assert!(carried.stated > carried.louder, "{carried:?}");
        assert!(integrate(&left(4000.0, 0.0), 0.0).louder > carried.stated - 10.0);
    }
}
