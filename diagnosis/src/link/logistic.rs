//! The link itself, and the one in force.

use super::support::{Support, TERMS};
use crate::verdict::answer::Diagnosis;
use std::sync::OnceLock;

/// The link that is in force: term, coefficient, standard deviation.
pub(super) const IN_FORCE: &str = include_str!("../../link.csv");

/// A logistic function of what speaks for an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// A coefficient for each of [`Support::terms`].
    pub coefficients: [f64; TERMS.len()],
}

impl Link {
    /// The one in force.
    ///
    /// # Panics
    /// Never: a test reads the file.
    #[must_use]
    pub fn in_force() -> &'static Self {
        static LINK: OnceLock<Link> = OnceLock::new();
        LINK.get_or_init(|| Self::parse(IN_FORCE).unwrap_or_default())
    }

    /// Of a file of coefficients; none where a term lacks or is no number.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let mut link = Self::default();
        for (coefficient, term) in link.coefficients.iter_mut().zip(&TERMS) {
            let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
            let cells = lines.find(|cells| cells.first() == Some(&term.name))?;
            *coefficient = cells.get(1)?.parse().ok()?;
        }
        Some(link)
    }

    /// Probability that the effect acts, or one of those that it stands for.
    #[must_use]
    pub fn probability(&self, support: &Support) -> f64 {
        let terms = support.terms();
        let ln_odds: f64 = terms
            .iter()
            .zip(&self.coefficients)
            .map(|(x, c)| x * c)
            .sum();
        1.0 / (1.0 + (-ln_odds).exp())
    }
}

/// States the probability of all that an answer names. What is in no catalogue and predicts the same shares it, by its odds.
pub fn state_probabilities(answer: &mut Diagnosis) {
    let stated = answer.effects.iter().map(|effect| {
        let of_class = Link::in_force().probability(&Support::of(effect, answer));
        of_class / (1.0 + effect.odds.unlisted)
    });
    let stated: Vec<f64> = stated.collect();
    for (effect, probability) in answer.effects.iter_mut().zip(stated) {
        effect.probability = probability;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::answer::{Named, Verdict};
    use crate::verdict::odds::Odds;

    /// Larger odds never make it less probable, nor more that is left more probable.
    #[test]
    fn the_link_in_force_is_monotone() {
        let link = Link::in_force();
        let at = |ln_odds, ln_floors, ln_left| {
            link.probability(&Support {
                ln_odds,
                ln_floors,
                ln_left,
                ..Support::default()
            })
        };
        assert!(at(7.0, 0.0, 0.1) >= at(1.0, 0.0, 0.1));
        assert!(at(3.0, 2.0, 0.1) >= at(3.0, -2.0, 0.1));
        assert!(at(3.0, 0.0, 0.1) >= at(3.0, 0.0, 1.0));
    }

    #[test]
    fn a_file_that_lacks_a_term_is_no_link() {
        let text = "# made\nterm,coefficient,deviation\nalways,1.5,0.2\n";
        assert_eq!(Link::parse(text), None);
    }

    #[test]
    fn what_is_in_no_catalogue_and_predicts_the_same_takes_half() {
        let of = |unlisted| {
            let mut answer = Diagnosis {
                verdict: Verdict::Named,
                effects: vec![Named {
                    name: "extra_harmonics".into(),
                    odds: Odds {
                        unlisted,
                        ..Odds::default()
                    },
                    ..Named::default()
                }],
                ..Diagnosis::default()
            };
            state_probabilities(&mut answer);
            answer.effects[0].probability
        };
        assert!((of(1.0) - 0.5 * of(0.0)).abs() < 1e-12 && of(0.0) > 0.0);
    }
}
