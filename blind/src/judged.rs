//! One case, its truth beside its answer.

use crate::claim::Claim;
use crate::ideal::Ideal;
use crate::stated::Stated;
use crate::verdicts::coordinates;
use diagnosis::figures::limits::VISIBLE_GAP_RATIO;
use diagnosis::verdict::answer::{Diagnosis, Verdict};
use effects::{Card, Detection};
use serde::{Deserialize, Serialize};
use specimens::{Case, Kind};

/// One case, its truth beside its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The truth.
    pub case: Case,
    /// The answer's verdict.
    pub verdict: Verdict,
    /// What it named.
    pub named: Vec<String>,
    /// What it could not tell from those.
    pub aliases: Vec<String>,
    /// Each named cause with its stated probability.
    #[serde(default)]
    pub stated: Vec<Stated>,
    /// Where it saw the gap, most of it first.
    pub places: Vec<String>,
    /// Its claim, where it named something.
    pub claim: Option<Claim>,
    /// What was named with the true effect taken out of the catalogue.
    pub without: Option<Vec<String>>,
    /// Of two effects, those that leave no gap by themselves: the baseline takes them, and nobody can tell them.
    pub hidden: Option<Vec<String>>,
    /// What the recording shows of the effects, where that was looked at.
    #[serde(default)]
    pub ideal: Option<Ideal>,
}

impl Judged {
    /// From the truth and the answer.
    #[must_use]
    pub fn new(
        case: &Case,
        answer: &Diagnosis,
        claim: Option<Claim>,
        without: Option<Vec<String>>,
    ) -> Self {
        let unexplained = answer.unexplained.place.iter();
        Self {
            case: case.clone(),
            verdict: answer.verdict,
            named: answer.effects.iter().map(|e| e.name.clone()).collect(),
            aliases: answer
                .effects
                .iter()
                .flat_map(|e| e.aliases.clone())
                .collect(),
            stated: Stated::of(answer),
            places: unexplained
                .chain(&answer.place)
                .map(|p| p.coordinate.clone())
                .collect(),
            claim,
            without,
            hidden: None,
            ideal: None,
        }
    }

    /// Names of what is wrong.
    #[must_use]
    pub fn truth(&self) -> Vec<&str> {
        self.case.effects.iter().map(|e| e.name.as_str()).collect()
    }

    /// Whether a name is that of noise above the stated one, and the noise is stated too low.
    #[must_use]
    pub fn is_louder_noise(&self, name: &str) -> bool {
        name == effects::name_of(Detection::AsNoise)
            && self.case.noise_over_stated() > VISIBLE_GAP_RATIO
    }

    /// Whether the courier has an effect. Noise above the stated one acts as well where the noise is stated too low.
    #[must_use]
    pub fn acts(&self, name: &str) -> bool {
        self.truth().contains(&name) || self.is_louder_noise(name)
    }

    /// What is named but for noise above the stated one, where the noise is stated too low: it is there, and need not be named.
    #[must_use]
    pub fn told(&self) -> Vec<&str> {
        let truth = self.truth();
        let is_told = |name: &&str| !self.is_louder_noise(name) || truth.contains(name);
        let named = self.named.iter().map(String::as_str);
        named.filter(is_told).collect()
    }

    /// Whether the answer is right for its kind: `no_gap`; first named cause; all of several and nothing else; `unknown`, located.
    #[must_use]
    pub fn right(&self) -> bool {
        let (truth, told) = (self.truth(), self.told());
        match self.case.kind {
            Kind::None => !self.is_false_alarm() && self.verdict != Verdict::InsufficientData,
            Kind::Single => told.first().is_some_and(|n| *n == truth[0]),
            Kind::Pair | Kind::Triple => {
                told.len() == truth.len() && truth.iter().all(|t| told.contains(t))
            }
            Kind::Unlisted => self.verdict == Verdict::Unknown && self.located(),
        }
    }

    /// A gap was seen where there is none but by noise that is stated too low.
    #[must_use]
    pub fn is_false_alarm(&self) -> bool {
        let by_noise = !self.named.is_empty() && self.told().is_empty();
        self.detected() && !by_noise
    }

    /// Whether each of two effects leaves a gap by itself, where that was looked at.
    #[must_use]
    pub fn both_show(&self) -> bool {
        self.hidden.as_ref().is_some_and(Vec::is_empty)
    }

    fn located(&self) -> bool {
        let right = coordinates(self.truth()[0]);
        self.places
            .iter()
            .take(3)
            .any(|place| right.iter().any(|r| place.contains(r)))
    }

    /// Something was named that is not there.
    #[must_use]
    pub fn wrong_culprit(&self) -> bool {
        let truth = self.truth();
        self.told().iter().any(|n| !truth.contains(n))
    }

    /// Whether each of its effects does as much on the recording as is worth a name, where that was looked at.
    #[must_use]
    pub fn is_worth_a_name(&self) -> bool {
        self.ideal.is_some_and(|ideal| ideal.worth_a_name)
    }

    /// A gap was seen.
    #[must_use]
    pub fn detected(&self) -> bool {
        !matches!(self.verdict, Verdict::NoGap | Verdict::InsufficientData)
    }

    /// Another cause was named where the true one was taken out of the catalogue; free harmonics are none.
    #[must_use]
    pub fn replaced(&self) -> Option<bool> {
        let names = self.without.as_ref()?;
        Some(names.iter().any(|name| !effects::has(name, Card::is_shape)))
    }

    /// Column of the confusion matrix.
    #[must_use]
    pub fn answered(&self) -> String {
        match self.verdict {
            Verdict::NoGap => "no_gap".into(),
            Verdict::Unknown => "unknown".into(),
            Verdict::InsufficientData => "insufficient_data".into(),
            Verdict::Named | Verdict::Alias => self.named.first().cloned().unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use specimens::Conditions;

    /// A courier without any effect that states its noise so, as it is answered by noise above the stated one.
    fn louder(wanted: impl Fn(f64) -> bool) -> Judged {
        let drawn = (0..10_000).map(|seed| Case {
            number: 0,
            seed,
            kind: Kind::None,
            effects: Vec::new(),
            conditions: Conditions::Drawn,
        });
        let case = drawn
            .into_iter()
            .find(|case| wanted(case.noise_over_stated()));
        let mut out = Judged::new(&case.unwrap(), &Diagnosis::default(), None, None);
        out.verdict = Verdict::Named;
        out.named = vec![effects::name_of(Detection::AsNoise).into()];
        out
    }

    #[test]
    fn noise_that_is_stated_too_low_is_there() {
        let low = louder(|over| over > 1.15);
        assert!(low.right() && !low.is_false_alarm() && !low.wrong_culprit());
        let right = louder(|over| over == 1.0);
        assert!(!right.right() && right.is_false_alarm() && right.wrong_culprit());
    }
}
