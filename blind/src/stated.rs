//! A named cause with its stated probability, and whether it is true.

use crate::judged::Judged;
use diagnosis::verdict::answer::{Diagnosis, Verdict};
use serde::{Deserialize, Serialize};

/// A named cause as it was told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// Its name.
    pub name: String,
    /// The probability that is stated of it.
    pub probability: f64,
    /// Where the verdict is an alias: what it stands for as well.
    pub aliases: Vec<String>,
}

impl Stated {
    /// All that an answer names.
    #[must_use]
    pub fn of(answer: &Diagnosis) -> Vec<Self> {
        let is_class = answer.verdict == Verdict::Alias;
        let stated = answer.effects.iter().map(|effect| Self {
            name: effect.name.clone(),
            probability: effect.probability,
            aliases: if is_class {
                effect.aliases.clone()
            } else {
                Vec::new()
            },
        });
        stated.collect()
    }

    /// Whether it acts, or one of those that it stands for: the courier has it. Noise above the stated one acts as well where the
    /// noise is stated too low.
    #[must_use]
    pub fn is_true(&self, of: &Judged) -> bool {
        let truth = of.truth();
        let acts = |name: &str| truth.contains(&name) || of.is_louder_noise(name);
        acts(&self.name) || self.aliases.iter().any(|name| acts(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::verdict::answer::Named;
    use specimens::{Case, Conditions, Drawn, Kind};

    /// An answer to a courier with `velocity_lag`: what is named, what it cannot be told from, the verdict.
    fn answered(name: &str, alias: &str, verdict: Verdict) -> bool {
        let case = Case {
            number: 0,
            seed: 0,
            kind: Kind::Single,
            effects: vec![Drawn {
                name: "velocity_lag".into(),
                size_m: 1.0e-6,
            }],
            conditions: Conditions::Usual,
        };
        let named = Named {
            name: name.into(),
            aliases: vec![alias.into()],
            ..Named::default()
        };
        let answer = Diagnosis {
            verdict,
            effects: vec![named],
            ..Diagnosis::default()
        };
        let judged = Judged::new(&case, &answer, None, None);
        judged.stated[0].is_true(&judged)
    }

    #[test]
    fn a_class_is_true_if_it_holds_what_acts() {
        assert!(answered("velocity_lag", "hysteresis", Verdict::Named));
        assert!(answered("hysteresis", "velocity_lag", Verdict::Alias));
        // A name alone does not stand for those that are less likely.
        assert!(!answered("hysteresis", "velocity_lag", Verdict::Named));
        assert!(!answered("hysteresis", "psd_latency", Verdict::Alias));
    }
}
