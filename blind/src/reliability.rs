//! Whether the stated probabilities are probabilities: how often what has one is true, tenth by tenth (Murphy and Winkler 1977).

use crate::figure::wilson;
use crate::judged::Judged;
use serde::{Deserialize, Serialize};

/// The stated probabilities are sorted into so many classes of equal width.
const TENTHS: usize = 10;
/// Largest deviation of a tenth that is wanted: it was asked for.
const WANTED: f64 = 0.05;
/// A probability that is nearer to 0 or 1 counts as this in the logarithm: no check has a million couriers.
const NEAREST: f64 = 1.0e-6;

/// Causes that were named with a probability of one tenth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tenth {
    /// From this probability on.
    pub from: f64,
    /// To this one.
    pub to: f64,
    /// Causes that were named with it.
    pub named: usize,
    /// Of these, what is true.
    pub right: usize,
    /// Mean of what was stated.
    pub stated: f64,
    /// Share that is true less the mean of what was stated.
    pub deviation: f64,
    /// 95 % interval of that (Wilson 1927).
    pub interval: [f64; 2],
}

impl Tenth {
    /// Least deviation that its interval allows.
    #[must_use]
    pub fn shown(&self) -> f64 {
        let [low, high] = self.interval;
        low.max(-high).max(0.0)
    }
}

/// How the largest deviation of a tenth compares with what is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// No tenth deviates by more.
    Reached,
    /// A tenth deviates by more, with 95 % probability.
    NotReached,
    /// A tenth deviates by more, which may be chance.
    TooFewCases,
    /// Nothing was named.
    NotTried,
}

/// The stated probabilities beside what is true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reliability {
    /// The tenths that any cause was named in, the lowest first.
    pub tenths: Vec<Tenth>,
    /// Causes that were named.
    pub named: usize,
    /// Of these, what is true.
    pub right: usize,
    /// Mean logarithm of the probability that was given to what came true; nearer to 0 is better.
    pub log_score: f64,
    /// The same of one probability for all: the share that is true.
    pub base_log_score: f64,
    /// The tenth that deviates most: the farthest from 0 with its whole interval, and of those that are equal the farthest itself.
    pub worst: Option<Tenth>,
    /// Largest deviation that is wanted.
    pub wanted: f64,
    /// What came of it.
    pub outcome: Outcome,
}

impl Reliability {
    /// Of all causes that were named.
    #[must_use]
    pub fn of(judged: &[Judged]) -> Self {
        let causes = judged.iter().flat_map(|one| {
            let stated = one.stated.iter();
            stated.map(|cause| (cause.probability, cause.is_true(|name| one.acts(name))))
        });
        Self::of_causes(&causes.collect::<Vec<_>>())
    }

    /// Of stated probabilities and what came true.
    #[must_use]
    pub fn of_causes(causes: &[(f64, bool)]) -> Self {
        let tenths: Vec<Tenth> = (0..TENTHS).filter_map(|k| tenth(k, causes)).collect();
        let right = causes.iter().filter(|cause| cause.1).count();
        let base = right as f64 / causes.len().max(1) as f64;
        let farther = |a: &&Tenth, b: &&Tenth| {
            let by_interval = a.shown().total_cmp(&b.shown());
            by_interval.then(a.deviation.abs().total_cmp(&b.deviation.abs()))
        };
        let outcome = if causes.is_empty() {
            Outcome::NotTried
        } else if tenths.iter().all(|t| t.deviation.abs() <= WANTED) {
            Outcome::Reached
        } else if tenths.iter().any(|t| t.shown() > WANTED) {
            Outcome::NotReached
        } else {
            Outcome::TooFewCases
        };
        Self {
            named: causes.len(),
            right,
            log_score: log_score(causes.iter().copied()),
            base_log_score: log_score(causes.iter().map(|cause| (base, cause.1))),
            worst: tenths.iter().max_by(farther).cloned(),
            tenths,
            wanted: WANTED,
            outcome,
        }
    }
}

/// One tenth; none where nothing was named with such a probability.
fn tenth(k: usize, causes: &[(f64, bool)]) -> Option<Tenth> {
    let class = |probability: f64| ((TENTHS as f64 * probability) as usize).min(TENTHS - 1);
    let own: Vec<&(f64, bool)> = causes.iter().filter(|cause| class(cause.0) == k).collect();
    let (named, right) = (own.len(), own.iter().filter(|cause| cause.1).count());
    let stated = own.iter().map(|cause| cause.0).sum::<f64>() / named as f64;
    (named > 0).then(|| Tenth {
        from: k as f64 / TENTHS as f64,
        to: (k + 1) as f64 / TENTHS as f64,
        named,
        right,
        stated,
        deviation: right as f64 / named as f64 - stated,
        interval: wilson(right, named).map(|share| share - stated),
    })
}

/// Mean logarithm of the probability that was given to what came true.
fn log_score(causes: impl ExactSizeIterator<Item = (f64, bool)>) -> f64 {
    let count = causes.len().max(1) as f64;
    let given = causes.map(|(probability, is_true)| {
        let given = if is_true {
            probability
        } else {
            1.0 - probability
        };
        given.clamp(NEAREST, 1.0).ln()
    });
    given.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many causes with a probability, so many of them true.
    fn causes(list: &[(f64, usize, usize)]) -> Vec<(f64, bool)> {
        let of = |(probability, named, right): &(f64, usize, usize)| {
            let (probability, right) = (*probability, *right);
            (0..*named).map(move |k| (probability, k < right))
        };
        list.iter().flat_map(of).collect()
    }

    #[test]
    fn probabilities_that_come_true_as_often_as_they_say_are_reached() {
        let told = Reliability::of_causes(&causes(&[(0.95, 100, 94), (0.55, 40, 23)]));
        assert_eq!(
            (told.outcome, told.named, told.right),
            (Outcome::Reached, 140, 117)
        );
        let worst = told.worst.unwrap();
        assert!((worst.deviation - 0.025).abs() < 1e-12, "{worst:?}");
        assert_eq!([told.tenths[0].from, told.tenths[1].from], [0.5, 0.9]);
    }

    #[test]
    fn a_tenth_that_is_too_sure_is_not_reached() {
        let told = Reliability::of_causes(&causes(&[(0.99, 200, 170), (0.3, 1, 1)]));
        assert_eq!(told.outcome, Outcome::NotReached);
        // A single cause deviates by more, and its interval tells less.
        let worst = told.worst.unwrap();
        assert_eq!((worst.from, worst.named), (0.9, 200));
        assert!((worst.deviation + 0.14).abs() < 1e-12);
        // Wilson's interval of 170 of 200 is 0.7939 to 0.8929.
        let [low, high] = worst.interval;
        assert!((low + 0.1961).abs() < 1e-3 && (high + 0.0971).abs() < 1e-3);
    }

    #[test]
    fn a_deviation_that_may_be_chance_is_told_so() {
        let few = Reliability::of_causes(&causes(&[(0.9, 10, 8)]));
        assert_eq!(few.outcome, Outcome::TooFewCases);
        assert_eq!(Reliability::of_causes(&[]).outcome, Outcome::NotTried);
    }

    #[test]
    fn the_log_score_is_best_where_each_has_its_own_probability() {
        let told = Reliability::of_causes(&causes(&[(0.9, 10, 9), (0.1, 10, 1)]));
        let own = 0.9 * 0.9_f64.ln() + 0.1 * 0.1_f64.ln();
        assert!((told.log_score - own).abs() < 1e-12);
        assert!((told.base_log_score - 0.5_f64.ln()).abs() < 1e-12);
        let wrongly_sure = Reliability::of_causes(&causes(&[(1.0, 1, 0)]));
        assert!((wrongly_sure.log_score - NEAREST.ln()).abs() < 1e-12);
    }

    /// What is on the edge of two tenths is in the upper one, and 1 in the last.
    #[test]
    fn each_probability_is_in_one_tenth() {
        let told = Reliability::of_causes(&causes(&[(0.0, 1, 0), (0.5, 1, 0), (1.0, 1, 1)]));
        let from: Vec<f64> = told.tenths.iter().map(|t| t.from).collect();
        assert_eq!(from, [0.0, 0.5, 0.9]);
    }
}
