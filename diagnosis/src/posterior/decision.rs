//! From weighed sets to the verdict: ordered reasons, each with its number.

use super::alias::{class, simplest};
use super::discrepancy::excess;
use super::hypotheses::{Hypothesis, Says, give_way_to_causes, hypotheses, own_courses_give_way};
use super::problem::Problem;
use super::weighed::Weighed;
use crate::verdict::answer::Verdict;
use std::fmt;

/// One step of the decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// What was asked.
    pub asked: &'static str,
    /// What was found.
    pub found: f64,
    /// From where on the answer is yes.
    pub limit: f64,
    /// The answer.
    pub yes: bool,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let answer = if self.yes { "yes" } else { "no" };
        write!(
            f,
            "{} {answer} ({:.3}, limit {:.3})",
            self.asked, self.found, self.limit
        )
    }
}

/// How the probability is shared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masses {
    /// Nothing that is worth a name.
    pub no_gap: f64,
    /// A set of effects, or louder noise, that leaves little.
    pub named: f64,
    /// A gap that no set explains.
    pub unknown: f64,
}

/// An effect, or louder noise, of the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Inclusion {
    /// Its block; none for louder noise.
    pub block: Option<usize>,
    /// Probability that it acts, or one of those that would do in its place, in a set that explains the gap.
    pub probability: f64,
    /// Whitened squares over the noise that it does.
    pub power: f64,
    /// Blocks that would do in its place.
    pub aliases: Vec<usize>,
}

/// The decision.
#[derive(Clone, Debug)]
pub struct Decision {
    /// Verdict.
    pub verdict: Verdict,
    /// What is named, the largest first.
    pub named: Vec<Inclusion>,
    /// Place, among all sets, of the one that is told: of the named ones the likeliest, or else the likeliest of all.
    pub first: usize,
    /// Whitened squares over the noise that the first set explains.
    pub explained: f64,
    /// Whitened squares over the noise that it leaves, and nothing named explains.
    pub left: f64,
    /// The same as a share of both.
    pub left_share: f64,
    /// Whitened squares over the noise that the best set leaves, what its effects' forms may lack among them.
    pub excess: f64,
    /// Blocks of coordinates that hold what it leaves, with their share of it.
    pub places: Vec<(usize, f64)>,
    /// How the probability is shared.
    pub masses: Masses,
    /// Steps.
    pub reasons: Vec<Reason>,
    /// Logarithm of the sum of all weights: the evidence of the whole comparison.
    pub log_evidence: f64,
}

/// Decides. `all` is ordered by weight; `noise_is_white` tells whether what the best set leaves has been shown to be noise.
pub fn decide(problem: &Problem, all: &[Weighed], noise_is_white: bool) -> Decision {
    let mut hypotheses = hypotheses(problem, all, noise_is_white);
    give_way_to_causes(problem, all, &mut hypotheses);
    own_courses_give_way(problem, all, &mut hypotheses);
    let total = super::noise_scale::log_sum(hypotheses.iter().map(|h| h.log_weight));
    let probability = |h: &Hypothesis| (h.log_weight - total).exp();
    let mass = |says: Says| {
        hypotheses
            .iter()
            .filter(|h| h.says == says)
            .map(probability)
            .fold(0.0, |a, b| a + b) // the sum of none is -0 otherwise
    };
    let masses = Masses {
        no_gap: mass(Says::NoGap),
        named: mass(Says::Named),
        unknown: mass(Says::Unknown),
    };
    let of_set = |k: usize| hypotheses.iter().filter(move |h| h.set == k);
    let best = &all[0];
    let left: f64 = {
        let whole: f64 = of_set(0).map(probability).sum();
        of_set(0).map(|h| probability(h) * h.left).sum::<f64>() / whole.max(f64::MIN_POSITIVE)
    };
    let explained = best.explained;
    let mut reasons = vec![
        reason("Is a gap likelier than none?", 1.0 - masses.no_gap, 0.5),
        reason(
            "Is it likelier that a set of effects explains it than that none does?",
            masses.named,
            masses.unknown,
        ),
    ];
    let mut out = Decision {
        verdict: Verdict::NoGap,
        first: of_nothing(all),
        named: Vec::new(),
        explained,
        left,
        left_share: left / (left + explained).max(f64::MIN_POSITIVE),
        excess: excess(&best.left),
        places: places(problem, best),
        masses,
        reasons: Vec::new(),
        log_evidence: total,
    };
    if reasons[0].yes {
        (out.verdict, out.first) = (Verdict::Unknown, 0);
        if reasons[1].yes {
            let by_set = |k: usize| {
                let named = of_set(k).filter(|h| h.says == Says::Named);
                named.map(probability).sum::<f64>()
            };
            let first = (0..all.len())
                .max_by(|a, b| by_set(*a).total_cmp(&by_set(*b)))
                .unwrap_or(0);
            let first = simplest(problem, all, first);
            out.first = first;
            // What a set of fewer of its own effects predicts as well is no other cause.
            let own = all[first].set();
            let others = |k: usize| all[k].set().iter().any(|b| !own.contains(b));
            let rivals = class(problem, all, first).into_iter();
            let rivals: Vec<_> = rivals.filter(|(k, _)| others(*k)).collect();
            let nearest = rivals
                .iter()
                .map(|(_, d)| d.squares / d.limit)
                .fold(f64::INFINITY, f64::min);
            let alias = Reason {
                asked: "Does another set predict the same on this motion?",
                found: nearest,
                limit: 1.0,
                yes: !rivals.is_empty(),
            };
            out.verdict = if alias.yes {
                Verdict::Alias
            } else {
                Verdict::Named
            };
            reasons.push(alias);
            let rivals: Vec<usize> = rivals.into_iter().map(|r| r.0).collect();
            out.named = named(all, first, &rivals, &hypotheses, total, masses.named);
        }
    }
    out.reasons = reasons;
    out
}

/// Place of the likeliest set of no effect, which is told where there is no gap.
fn of_nothing(all: &[Weighed]) -> usize {
    all.iter().position(|w| w.set().is_empty()).unwrap_or(0)
}

fn reason(asked: &'static str, found: f64, limit: f64) -> Reason {
    Reason {
        asked,
        found,
        limit,
        yes: found > limit,
    }
}

/// The effects of a set, and louder noise, with their probabilities and aliases.
fn named(
    all: &[Weighed],
    first: usize,
    rivals: &[usize],
    hypotheses: &[Hypothesis],
    total: f64,
    mass: f64,
) -> Vec<Inclusion> {
    let among = |of_it: &dyn Fn(&Hypothesis) -> bool| {
        let list = hypotheses
            .iter()
            .filter(|h| h.says == Says::Named && of_it(h));
        let sum: f64 = list.map(|h| (h.log_weight - total).exp()).sum();
        // Rounding may make a little more than one of all of them.
        sum.min(1.0)
    };
    let set = all[first].set();
    let mut out: Vec<Inclusion> = Vec::new();
    for (block, power) in set.iter().zip(&all[first].powers) {
        let without = rivals.iter().filter(|r| !all[**r].set().contains(block));
        let mut aliases: Vec<usize> = without
            .flat_map(|r| all[*r].set())
            .filter(|b| !set.contains(b))
            .copied()
            .collect();
        aliases.sort_unstable();
        aliases.dedup();
        out.push(Inclusion {
            block: Some(*block),
            probability: among(&|h| {
                let set = all[h.set].set();
                set.contains(block) || aliases.iter().any(|b| set.contains(b))
            }),
            power: *power,
            aliases,
        });
    }
    let noise = among(&|h| h.noise);
    if noise > 0.5 * mass {
        let left = &all[first].left;
        let excess = all[first].noise.log_variance.exp_m1().max(0.0);
        let power = excess * left.degrees * (-left.log_noise).exp();
        out.push(Inclusion {
            block: None,
            probability: noise,
            power,
            aliases: Vec::new(),
        });
    }
    out.sort_by(|a, b| b.power.total_cmp(&a.power));
    out
}

/// Coordinates that hold what a set leaves.
fn places(problem: &Problem, best: &Weighed) -> Vec<(usize, f64)> {
    let unlisted = |b: &usize| problem.effects.iter().any(|e| e.block == *b && !e.listed);
    let of_set = best.set().iter().copied().zip(best.powers.iter().copied());
    let mut out: Vec<(usize, f64)> = of_set.filter(|(b, _)| unlisted(b)).collect();
    if let Some((shapes, _)) = &best.nameless {
        let each = shapes.coordinates.iter().zip(&shapes.powers);
        out.extend(each.map(|(c, power)| (problem.coordinates[*c], *power)));
    }
    let sum: f64 = out.iter().map(|(_, power)| power).sum();
    out.iter_mut()
        .for_each(|(_, power)| *power /= sum.max(f64::MIN_POSITIVE));
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

#[cfg(test)]
mod tests;
