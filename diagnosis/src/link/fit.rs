//! Fits a link to causes of which it is known whether they act.

use super::logistic::Link;
use super::support::{Sign, Support, TERMS};
use nalgebra::{SMatrix, SVector};

const COUNT: usize = TERMS.len();
/// Newton's steps; from nothing some ten are enough (Hastie, Tibshirani and Friedman 2009, section 4.4.1).
const MOST_STEPS: usize = 100;
/// A step that is smaller moves no digit of what is written: derived from the four places of `link.csv`.
const SMALL_STEP: f64 = 1.0e-10;

/// A link with what its coefficients are known to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// The likeliest one.
    pub link: Link,
    /// Standard deviation of each coefficient (Laplace); zero for one that its sign holds at zero.
    pub deviations: [f64; COUNT],
}

type Vector = SVector<f64, COUNT>;
type Matrix = SMatrix<f64, COUNT, COUNT>;

impl Fitted {
    /// The coefficients that make what came true likeliest, with their priors. A coefficient of the wrong sign is held at zero.
    #[must_use]
    pub fn of(cases: &[(Support, bool)]) -> Self {
        let mut free = [true; COUNT];
        loop {
            let (coefficients, hessian) = likeliest(cases, free);
            let wrong = (0..COUNT).filter(|k| free[*k] && TERMS[*k].sign.forbids(coefficients[*k]));
            // One after the other: the farthest first, since the others may turn.
            let far = |k: &usize| coefficients[*k].abs() / TERMS[*k].prior;
            if let Some(worst) = wrong.max_by(|a, b| far(a).total_cmp(&far(b))) {
                free[worst] = false;
                continue;
            }
            let covariance = hessian.try_inverse().unwrap_or_default();
            let deviation = |k: usize| {
                if free[k] {
                    covariance[(k, k)].max(0.0).sqrt()
                } else {
                    0.0
                }
            };
            return Self {
                link: Link {
                    coefficients: coefficients.into(),
                },
                deviations: std::array::from_fn(deviation),
            };
        }
    }
}

/// The likeliest coefficients, the others held at zero, and the second derivative of minus the logarithm of their density.
fn likeliest(cases: &[(Support, bool)], free: [bool; COUNT]) -> (Vector, Matrix) {
    let mut coefficients = Vector::zeros();
    let mut hessian = Matrix::zeros();
    for _ in 0..MOST_STEPS {
        let mut gradient = Vector::zeros();
        hessian = Matrix::zeros();
        for k in 0..COUNT {
            let weight = TERMS[k].prior.powi(-2);
            gradient[k] = weight * coefficients[k];
            hessian[(k, k)] = weight;
        }
        let link = Link {
            coefficients: coefficients.into(),
        };
        for (support, is_true) in cases {
            let x = Vector::from(support.terms());
            let p = link.probability(support);
            gradient += x * (p - f64::from(u8::from(*is_true)));
            hessian += x * x.transpose() * (p * (1.0 - p));
        }
        for k in (0..COUNT).filter(|k| !free[*k]) {
            gradient[k] = 0.0;
            hessian.row_mut(k).fill(0.0);
            hessian.column_mut(k).fill(0.0);
            hessian[(k, k)] = 1.0;
        }
        let Some(cholesky) = hessian.cholesky() else {
            break;
        };
        let step = cholesky.solve(&gradient);
        coefficients -= step;
        if step.amax() < SMALL_STEP {
            break;
        }
    }
    (coefficients, hessian)
}

impl Sign {
    fn forbids(self, coefficient: f64) -> bool {
        match self {
            Self::Any => false,
            Self::Positive => coefficient < 0.0,
            Self::Negative => coefficient > 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::logistic::IN_FORCE;
    use effects::random::{ChaCha8Rng, SeedableRng, uniform};

    /// The couriers that the link in force was fitted on.
    const CASES: &str = include_str!("../../link-cases.csv");

    #[test]
    fn the_link_in_force_is_what_its_cases_give() {
        let link = Link::parse(IN_FORCE).unwrap();
        let cases = Support::cases(CASES).unwrap();
        assert!(cases.len() > 100, "{}", cases.len());
        let fitted = Fitted::of(&cases);
        for (kept, fitted) in link.coefficients.iter().zip(fitted.link.coefficients) {
            // Written to four places.
            assert!((kept - fitted).abs() < 1e-4, "{kept} {fitted}");
        }
    }

    /// Causes that act as often as a link says.
    fn drawn(link: &Link, count: usize) -> Vec<(Support, bool)> {
        let mut rng = ChaCha8Rng::seed_from_u64(38);
        let one = |_| {
            let support = Support {
                ln_odds: uniform(&mut rng, 0.0, 7.0),
                ln_floors: uniform(&mut rng, -2.0, 2.0),
                ..Support::default()
            };
            let acts = uniform(&mut rng, 0.0, 1.0) < link.probability(&support);
            (support, acts)
        };
        (0..count).map(one).collect()
    }

    fn link(always: f64, ln_odds: f64) -> Link {
        let mut link = Link::default();
        for (coefficient, term) in link.coefficients.iter_mut().zip(&TERMS) {
            *coefficient = match term.name {
                "always" => always,
                "ln_odds" => ln_odds,
                _ => 0.0,
            };
        }
        link
    }

    #[test]
    fn a_link_is_found_again() {
        let truth = link(-1.0, 0.5);
        let fitted = Fitted::of(&drawn(&truth, 4000));
        for k in 0..COUNT {
            let off = fitted.link.coefficients[k] - truth.coefficients[k];
            // A prior holds what the causes do not tell.
            assert!(
                off.abs() <= 4.0 * fitted.deviations[k],
                "{} {off}",
                TERMS[k].name
            );
        }
    }

    #[test]
    fn a_coefficient_of_the_wrong_sign_is_held_at_zero() {
        let fitted = Fitted::of(&drawn(&link(2.0, -0.5), 500));
        let place = TERMS
            .iter()
            .position(|term| term.name == "ln_odds")
            .unwrap();
        assert_eq!(fitted.link.coefficients[place], 0.0);
        assert_eq!(fitted.deviations[place], 0.0);
    }

    /// Where all that was named is true, the priors keep the probability from being certain.
    #[test]
    fn a_few_that_are_all_true_are_no_certainty() {
        let all_true: Vec<(Support, bool)> = drawn(&link(0.0, 0.0), 20)
            .into_iter()
            .map(|(support, _)| (support, true))
            .collect();
        let fitted = Fitted::of(&all_true);
        let p = fitted.link.probability(&all_true[0].0);
        assert!((0.7..0.999).contains(&p), "{p}");
    }
}
