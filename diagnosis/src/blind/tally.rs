//! From judged cases to the figures of the check.

use super::cases::{Case, Kind, SIZES_M};
use super::verdicts::coordinates;
use crate::report::{Diagnosis, HeldOut, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Claims are right within this share.
pub const CLAIM_WITHIN: f64 = 0.10;
/// Classes of size for detection.
const SIZE_CLASSES: usize = 5;

/// What was claimed of the gap after, and what is true of it; rms over the simulator's own scatter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Before, as claimed.
    pub before: f64,
    /// After, as claimed.
    pub claimed: f64,
    /// After, by `check` on the second recording.
    pub confirmed: Option<f64>,
    /// Largest difference of any channel's rms, as a share of the confirmed one.
    pub worst_channel: Option<f64>,
    /// Best possible: the same courier, motion and noise without its effects.
    pub best: Option<f64>,
}

impl Claim {
    /// Of an answer, its check, and its best possible.
    #[must_use]
    pub fn new(answer: &HeldOut, again: Option<&HeldOut>, best: Option<&HeldOut>) -> Self {
        let difference = |again: &HeldOut| {
            answer
                .channels
                .iter()
                .filter_map(|c| {
                    again
                        .channels
                        .iter()
                        .find(|a| a.channel == c.channel)
                        .map(|a| (c.after_rms_m / a.after_rms_m - 1.0).abs())
                })
                .fold(0.0, f64::max)
        };
        Self {
            before: answer.whitened_before,
            claimed: answer.whitened_after,
            confirmed: again.map(|a| a.whitened_after),
            worst_channel: again.map(difference),
            best: best.map(|b| b.whitened_before),
        }
    }

    /// Whether the claim is confirmed within `CLAIM_WITHIN`.
    #[must_use]
    pub fn holds(&self) -> Option<bool> {
        self.confirmed
            .map(|c| (self.claimed / c - 1.0).abs() <= CLAIM_WITHIN)
    }

    /// Whether it is within `CLAIM_WITHIN` of the best possible.
    #[must_use]
    pub fn best_reached(&self) -> Option<bool> {
        self.best.map(|b| self.claimed / b - 1.0 <= CLAIM_WITHIN)
    }
}

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
    /// Where it saw the gap, most of it first.
    pub places: Vec<String>,
    /// Its claim, where it named something.
    pub claim: Option<Claim>,
    /// What was named with the true effect taken out of the catalogue.
    pub without: Option<Vec<String>>,
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
            places: unexplained
                .chain(&answer.place)
                .map(|p| p.coordinate.clone())
                .collect(),
            claim,
            without,
        }
    }

    fn truth(&self) -> Vec<&str> {
        self.case.effects.iter().map(|e| e.name.as_str()).collect()
    }

    /// Whether the answer is right for its kind: `no_gap`; first named cause; both and nothing else; `unknown`, located.
    #[must_use]
    pub fn right(&self) -> bool {
        let truth = self.truth();
        match self.case.kind {
            Kind::None => self.verdict == Verdict::NoGap,
            Kind::Single => self.named.first().is_some_and(|n| n == truth[0]),
            Kind::Pair => {
                self.named.len() == 2 && truth.iter().all(|t| self.named.iter().any(|n| n == t))
            }
            Kind::Unlisted => self.verdict == Verdict::Unknown && self.located(),
        }
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
        self.named.iter().any(|n| !truth.contains(&n.as_str()))
    }

    /// Column of the confusion matrix.
    fn answered(&self) -> String {
        match self.verdict {
            Verdict::NoGap => "no_gap".into(),
            Verdict::Unknown => "unknown".into(),
            Verdict::InsufficientData => "insufficient_data".into(),
            Verdict::Named | Verdict::Alias => self.named.first().cloned().unwrap_or_default(),
        }
    }
}

/// A share with what was wanted of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What is counted.
    pub name: String,
    /// Cases in which it is so.
    pub count: usize,
    /// Cases looked at.
    pub of: usize,
    /// 95 % interval of the share (Wilson 1927).
    pub interval: [f64; 2],
    /// What is wanted.
    pub wanted: f64,
    /// True if at least that is wanted, false if at most.
    pub at_least: bool,
}

impl Figure {
    fn new(name: &str, outcomes: impl Iterator<Item = bool>, wanted: f64, at_least: bool) -> Self {
        let (count, of) = outcomes.fold((0, 0), |(count, of), yes| {
            (count + usize::from(yes), of + 1)
        });
        Self {
            name: name.into(),
            count,
            of,
            interval: wilson(count, of),
            wanted,
            at_least,
        }
    }

    /// The share; none of nothing.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.count as f64 / self.of as f64)
    }

    /// Whether it is reached; nothing looked at is nothing reached.
    #[must_use]
    pub fn reached(&self) -> bool {
        self.share().is_some_and(|s| {
            if self.at_least {
                s >= self.wanted
            } else {
                s <= self.wanted
            }
        })
    }
}

/// Wilson's score interval at 95 %.
fn wilson(count: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    const Z: f64 = 1.96;
    let (n, p) = (of as f64, count as f64 / of as f64);
    let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

/// Detection and naming of single effects within a class of size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Sizes, m.
    pub from_m: f64,
    /// To, m.
    pub to_m: f64,
    /// Single effects of that size.
    pub cases: usize,
    /// Of them with a gap seen.
    pub detected: usize,
    /// Of them with the first named cause right.
    pub named: usize,
}

/// The scores of a blind check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// 1.
    pub schema: u32,
    /// Hash that was printed first.
    pub seal: String,
    /// Cases.
    pub cases: usize,
    /// The figures that were asked for.
    pub figures: Vec<Figure>,
    /// Truth by answer: number of cases.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Single effects by size.
    pub detection: Vec<Detection>,
    /// Every case.
    pub judged: Vec<Judged>,
}

impl Score {
    /// Counts.
    #[must_use]
    pub fn new(seal: String, judged: Vec<Judged>) -> Self {
        let of = |kind: Kind| judged.iter().filter(move |j| j.case.kind == kind);
        let claims = || judged.iter().filter_map(|j| j.claim.as_ref());
        let right_claims = || {
            judged
                .iter()
                .filter(|j| !j.wrong_culprit())
                .filter_map(|j| j.claim.as_ref())
        };
        let withheld = |names: &Vec<String>| names.iter().any(|n| n != "extra_harmonics");
        let with_effect = || judged.iter().filter(|j| j.case.kind != Kind::None);
        let figures = vec![
            Figure::new(
                "one effect: first named cause right",
                of(Kind::Single).map(Judged::right),
                0.95,
                true,
            ),
            Figure::new(
                "two effects: both named and nothing else",
                of(Kind::Pair).map(Judged::right),
                0.85,
                true,
            ),
            Figure::new(
                "no effect: a false alarm",
                of(Kind::None).map(|j| !j.right()),
                0.01,
                false,
            ),
            Figure::new(
                "an unlisted effect: unknown, rightly located",
                of(Kind::Unlisted).map(Judged::right),
                0.90,
                true,
            ),
            Figure::new(
                "taken out by --without: another named in its place",
                judged
                    .iter()
                    .filter_map(|j| j.without.as_ref())
                    .map(withheld),
                0.05,
                false,
            ),
            Figure::new(
                "claimed gap within 10 % of check's on a second recording",
                claims().filter_map(Claim::holds),
                0.95,
                true,
            ),
            Figure::new(
                "claimed gap within 10 % of the best possible",
                right_claims().filter_map(Claim::best_reached),
                0.95,
                true,
            ),
            Figure::new(
                "open set: right cause, or rightly unknown",
                with_effect().map(Judged::right),
                0.662,
                true,
            ),
            Figure::new(
                "a wrong culprit among what is named",
                with_effect().map(Judged::wrong_culprit),
                0.05,
                false,
            ),
        ];
        let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for one in judged.iter().filter(|j| j.case.kind != Kind::Pair) {
            let truth = one
                .truth()
                .first()
                .map_or("nothing".to_owned(), |t| (*t).to_owned());
            *confusion
                .entry(truth)
                .or_default()
                .entry(one.answered())
                .or_default() += 1;
        }
        let detection = detection(&judged);
        Self {
            schema: 1,
            seal,
            cases: judged.len(),
            figures,
            confusion,
            detection,
            judged,
        }
    }
}

fn detection(judged: &[Judged]) -> Vec<Detection> {
    let step = (SIZES_M[1] / SIZES_M[0]).powf(1.0 / SIZE_CLASSES as f64);
    (0..SIZE_CLASSES)
        .map(|k| {
            let from_m = SIZES_M[0] * step.powi(k as i32);
            let to_m = from_m * step;
            let within: Vec<&Judged> = judged
                .iter()
                .filter(|j| {
                    j.case.kind == Kind::Single
                        && j.case.effects[0].size_m >= from_m
                        && j.case.effects[0].size_m < to_m
                })
                .collect();
            let seen =
                |j: &&&Judged| !matches!(j.verdict, Verdict::NoGap | Verdict::InsufficientData);
            let named = within.iter().filter(|j| j.right()).count();
            Detection {
                from_m,
                to_m,
                cases: within.len(),
                detected: within.iter().filter(seen).count(),
                named,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_wilsons() {
        // Newcombe 1998, table I: 81 of 263 is 0.2553 to 0.3662, 0 of 20 is 0 to 0.1611.
        let [low, high] = wilson(81, 263);
        assert!((low - 0.2553).abs() < 1e-4 && (high - 0.3662).abs() < 1e-4);
        assert!((wilson(0, 20)[1] - 0.1611).abs() < 1e-4);
    }

    #[test]
    fn nothing_looked_at_is_nothing_reached() {
        assert!(!Figure::new("", std::iter::empty(), 0.0, true).reached());
        assert!(Figure::new("", [true, true].into_iter(), 0.95, true).reached());
        assert!(!Figure::new("", [true].into_iter(), 0.01, false).reached());
    }
}
