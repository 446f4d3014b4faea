//! All sets of up to four effects, as far as they may matter, each with its weight under four hypotheses: with nameless shapes or without,
//! by noise near the stated one or louder.

use super::evidence::{Fitted, fitted, roughly};
use super::least_size::{log_ratio, powers};
use super::nameless::{Nameless, beside};
use super::noise_scale::{Left, NoiseScale, integrate, log_sum};
use super::reduced::Reduced;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most effects in a set.
pub const MOST: usize = 4;
/// Sets of each number of effects that are built upon: a bound on the work.
const BUILT_UPON: usize = 6;
/// Sets whose sizes are found together, with nameless shapes besides: a bound on the work.
const WITH_SHAPES: usize = 12;
/// Blocks with more columns than this are tried in pairs with the best single effects alone: a bound on the work.
const LARGE: usize = 200;

/// What is asked: columns with their priors.
pub struct Problem<'r> {
    /// Normal equations.
    pub reduced: &'r Reduced,
    /// Variance of the whitened residuals by the stated noise.
    pub stated: f64,
    /// Blocks of effects.
    pub effects: Vec<Prior>,
    /// Blocks of shapes over a coordinate.
    pub coordinates: Vec<usize>,
    /// Logarithm of the prior odds of each coordinate, and of louder noise.
    pub log_odds: f64,
}

/// An effect before the data.
#[derive(Clone, Copy, Debug)]
pub struct Prior {
    /// Its block.
    pub block: usize,
    /// Logarithm of its prior odds.
    pub log_odds: f64,
    /// Share of its amplitude that its form may lack.
    pub inexactness: f64,
}

/// A set with its weight.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// The fit.
    pub fitted: Fitted,
    /// What each effect does, in whitened squares over the noise.
    pub powers: Vec<f64>,
    /// Whitened squares that the effects' own forms may lack.
    pub lacking: f64,
    /// What the set leaves.
    pub left: Left,
    /// What cutting off trifles adds.
    pub log_least: f64,
    /// Logarithm of the prior odds of its effects.
    pub log_prior: f64,
    /// The noise.
    pub noise: NoiseScale,
    /// Nameless shapes beside it, and the noise with them.
    pub nameless: Option<(Nameless, NoiseScale)>,
}

impl Weighed {
    /// Blocks of the set.
    pub fn set(&self) -> &[usize] {
        &self.fitted.set
    }

    /// Logarithm of its weight without nameless shapes, by noise near the stated one and by louder noise.
    pub fn closed(&self, log_odds: f64) -> [f64; 2] {
        let common = self.log_least + self.log_prior;
        [
            common + self.noise.stated,
            common + self.noise.louder + log_odds,
        ]
    }

    /// The same with nameless shapes.
    pub fn open(&self, log_odds: f64) -> [f64; 2] {
        let Some((shapes, noise)) = &self.nameless else {
            return [f64::NEG_INFINITY; 2];
        };
        let common = self.log_least + self.log_prior + shapes.log_prior;
        [common + noise.stated, common + noise.louder + log_odds]
    }

    /// Logarithm of its whole weight.
    pub fn log_weight(&self, log_odds: f64) -> f64 {
        log_sum(self.closed(log_odds).into_iter().chain(self.open(log_odds)))
    }
}

/// Weighs the sets, the likeliest first.
pub fn weigh(problem: &Problem) -> Vec<Weighed> {
    let mut known: BTreeMap<Vec<usize>, Weighed> = BTreeMap::new();
    let count = problem.effects.len();
    add(problem, &mut known, vec![Vec::new()]);
    add(problem, &mut known, (0..count).map(|e| vec![e]).collect());
    let leading = best(problem, &known, 1);
    let large = |e: usize| problem.reduced.blocks[problem.effects[e].block].len() > LARGE;
    let all = (0..count).flat_map(|a| (0..a).map(move |b| vec![b, a]));
    let worth = |set: &Vec<usize>| {
        !set.iter().any(|e| large(*e)) || set.iter().any(|e| leading.iter().any(|l| l == &[*e]))
    };
    add(problem, &mut known, all.filter(worth).collect());
    for size in 3..=MOST.min(count) {
        let base = best(problem, &known, size - 1);
        add(problem, &mut known, with_one_more(&base, count));
        // An effect that was needed on the way may have become another one's.
        let base: Vec<Vec<usize>> = best(problem, &known, size);
        let exchanged = base.iter().take(2).flat_map(|set| {
            let drop = move |k: usize| [&set[..k], &set[k + 1..]].concat();
            with_one_more(&(0..set.len()).map(drop).collect::<Vec<_>>(), count)
        });
        let exchanged = exchanged.collect();
        add(problem, &mut known, exchanged);
    }
    let mut all: Vec<Weighed> = known.into_values().collect();
    let by_weight = |a: &Weighed, b: &Weighed| {
        let [a, b] = [a, b].map(|w| w.log_weight(problem.log_odds));
        b.total_cmp(&a)
    };
    all.sort_by(by_weight);
    // The empty set always: without it nothing is said of a gap that no effect explains.
    let place = all.iter().position(|w| w.set().is_empty()).unwrap_or(0);
    let shown: Vec<usize> = (0..all.len())
        .filter(|k| *k < WITH_SHAPES || *k == place)
        .collect();
    let exact: Vec<_> = shown
        .par_iter()
        .map(|k| exactly(problem, &all[*k]))
        .collect();
    for (k, exact) in shown.into_iter().zip(exact) {
        if let Some(exact) = exact {
            all[k] = exact;
        }
    }
    all.sort_by(by_weight);
    all
}

/// Sets with each of the effects besides.
fn with_one_more(base: &[Vec<usize>], count: usize) -> Vec<Vec<usize>> {
    let each = base.iter().flat_map(|set| {
        let more = (0..count).filter(|e| !set.contains(e));
        more.map(move |e| {
            let mut set = [&set[..], &[e]].concat();
            set.sort_unstable();
            set
        })
    });
    each.collect()
}

/// The likeliest sets of so many effects.
fn best(problem: &Problem, known: &BTreeMap<Vec<usize>, Weighed>, size: usize) -> Vec<Vec<usize>> {
    let mut list: Vec<(f64, &Vec<usize>)> = known
        .iter()
        .filter(|(set, _)| set.len() == size)
        .map(|(set, w)| (w.log_weight(problem.log_odds), set))
        .collect();
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    list.into_iter()
        .take(BUILT_UPON)
        .map(|(_, set)| set.clone())
        .collect()
}

/// The size that an effect has alone, and the width of the integral over it.
type Alone = (f64, f64);

fn add(problem: &Problem, known: &mut BTreeMap<Vec<usize>, Weighed>, mut sets: Vec<Vec<usize>>) {
    sets.sort_unstable();
    sets.dedup();
    sets.retain(|set| !known.contains_key(set));
    let alone = |e: &usize| -> Option<Alone> {
        let one = &known.get(&vec![*e])?.fitted;
        Some((one.log_variances[0], one.log_widths))
    };
    let starts: Vec<Option<Vec<Alone>>> = sets
        .iter()
        .map(|set| set.iter().map(alone).collect())
        .collect();
    let weighed: Vec<Option<Weighed>> = sets
        .par_iter()
        .zip(&starts)
        .map(|(set, start)| one(problem, set, start.as_deref()))
        .collect();
    for (set, weighed) in sets.into_iter().zip(weighed) {
        known.extend(weighed.map(|w| (set, w)));
    }
}

/// Weighs one set, told by places among the effects: a single effect, or a set of none, exactly; others from what each is alone.
fn one(problem: &Problem, set: &[usize], alone: Option<&[Alone]>) -> Option<Weighed> {
    let Problem {
        reduced, stated, ..
    } = *problem;
    let blocks: Vec<usize> = set.iter().map(|e| problem.effects[*e].block).collect();
    let fitted = match alone {
        Some(alone) if set.len() > 1 => roughly(reduced, &blocks, alone, stated)?,
        None if set.len() > 1 => return None,
        _ => fitted(reduced, &blocks, &vec![0.0; set.len()], stated)?,
    };
    Some(weighed(problem, fitted))
}

/// A set's weight from its fit.
fn weighed(problem: &Problem, fitted: Fitted) -> Weighed {
    let Problem {
        reduced, stated, ..
    } = *problem;
    let of = |b: &usize| problem.effects.iter().find(|e| e.block == *b);
    let priors = || fitted.set.iter().filter_map(of);
    let powers = powers(reduced, &fitted, stated);
    let inexactness: Vec<f64> = priors().map(|e| e.inexactness).collect();
    let lacking: f64 = powers
        .iter()
        .zip(&inexactness)
        .map(|(q, e)| e * e * q)
        .sum();
    let left = Left::of(reduced, &fitted, stated);
    Weighed {
        log_least: log_ratio(reduced, &fitted, &powers, &inexactness, stated),
        log_prior: priors().map(|e| e.log_odds).sum(),
        noise: integrate(&left, lacking / reduced.rows),
        nameless: None,
        fitted,
        powers,
        lacking,
        left,
    }
}

/// The same set with its sizes found together, and with the best nameless shapes beside it.
fn exactly(problem: &Problem, rough: &Weighed) -> Option<Weighed> {
    let sizes = &rough.fitted.log_variances;
    let fitted = fitted(problem.reduced, rough.set(), sizes, problem.stated)?;
    let mut out = weighed(problem, fitted);
    let known = (problem.stated, problem.log_odds);
    let shapes = beside(
        problem.reduced,
        &out.fitted,
        &problem.coordinates,
        &out.left,
        known,
    );
    out.nameless = shapes.map(|shapes| {
        let noise = integrate(&shapes.left, out.lacking / problem.reduced.rows);
        (shapes, noise)
    });
    Some(out)
}
