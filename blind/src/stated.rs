//! A named cause with its stated probability, and whether it is true.

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

    /// Whether it acts, or one of those that it stands for.
    #[must_use]
    pub fn is_true(&self, acts: impl Fn(&str) -> bool) -> bool {
        acts(&self.name) || self.aliases.iter().any(|name| acts(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::verdict::answer::Named;

    /// An answer to a courier with `velocity_lag`: what is named, what it cannot be told from, the verdict.
    fn answered(name: &str, alias: &str, verdict: Verdict) -> bool {
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
        Stated::of(&answer)[0].is_true(|name| name == "velocity_lag")
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
