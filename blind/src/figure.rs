//! A share of the cases, its interval, and what is wanted of it.

use crate::judged::Judged;
use serde::{Deserialize, Serialize};

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
    /// Share that an ideal observer has right in the mean ([`crate::ideal()`]), where that was looked at.
    #[serde(default)]
    pub ideal: Option<f64>,
}

impl Figure {
    /// Counts outcomes.
    #[must_use]
    pub fn new(
        name: &str,
        outcomes: impl Iterator<Item = bool>,
        wanted: f64,
        at_least: bool,
    ) -> Self {
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
            ideal: None,
        }
    }

    /// The same beside the share of these cases that an ideal observer has right, where that was looked at in each of them.
    #[must_use]
    pub fn beside_the_ideal<'a>(self, cases: impl Iterator<Item = &'a Judged>) -> Self {
        let seen: Option<Vec<f64>> = cases.map(|j| Some(j.ideal?.seen)).collect();
        let seen = seen.filter(|list| !list.is_empty());
        Self {
            ideal: seen.map(|list| list.iter().sum::<f64>() / list.len() as f64),
            ..self
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
pub(crate) fn wilson(count: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    const Z: f64 = 1.96;
    let (n, p) = (of as f64, count as f64 / of as f64);
    let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
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
