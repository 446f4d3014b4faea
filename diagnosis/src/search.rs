//! Which columns explain the gap: cross-validated residuals of sets of effects, forward, backward and by exchange.

use crate::gram::{Columns, FOLDS, Gram, solve, squares};
use nalgebra::DMatrix;
use std::collections::HashMap;

/// Sets are compared on these.
pub struct Arena<'a> {
    /// Products of the columns.
    pub gram: &'a Gram,
    /// The columns.
    pub columns: &'a Columns,
    training: Vec<DMatrix<f64>>,
    known: HashMap<Vec<usize>, Score>,
}

/// Held-out squares of a set of columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Whitened squares over all folds, each predicted from the others.
    pub squares: f64,
    /// The same by fold.
    pub fold: [f64; FOLDS],
    /// Sum of the folds' log evidence.
    pub log_evidence: f64,
}

/// A further effect must take this share of the whole gap.
pub const MINIMUM_SHARE: f64 = 0.025;
/// The same beside an effect with very many unknowns, whose own remainder is larger.
pub const MINIMUM_SHARE_BESIDE_FLEXIBLE: f64 = 0.05;
/// And this share of what those before it left.
pub const MINIMUM_OF_REST: f64 = 0.4;
/// And this many whitened squares, well past what chance gives the best of twenty candidates.
pub const MINIMUM_SQUARES: f64 = 60.0;
/// Amounts beyond this many prior deviations are of no physical size, however well they fit.
const IMPLAUSIBLE: f64 = 30.0;
/// No held-out model beats the noise: below this share of it, and where the baseline does not, it is an artefact.
const TOO_GOOD: f64 = 0.3;
/// Most effects in one answer.
const MOST: usize = 4;

impl<'a> Arena<'a> {
    /// Prepares the training sums.
    pub fn new(gram: &'a Gram, columns: &'a Columns) -> Self {
        let training = (0..FOLDS).map(|f| gram.training(Some(f))).collect();
        Self {
            gram,
            columns,
            training,
            known: HashMap::new(),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> f64 {
        self.gram.total_rows() as f64
    }

    /// True if already the baseline alone stays below the stated noise.
    fn overstated(&self) -> bool {
        let base: Vec<usize> = self.columns.blocks[0].columns.clone().collect();
        self.score_columns(&base).squares < 2.0 * TOO_GOOD * self.rows()
    }

    /// Held-out score of the baseline with some blocks.
    pub fn score(&mut self, blocks: &[usize]) -> Score {
        let mut key = blocks.to_vec();
        key.sort_unstable();
        key.dedup();
        if let Some(score) = self.known.get(&key) {
            return *score;
        }
        let mut list: Vec<usize> = self.columns.blocks[0].columns.clone().collect();
        for &block in &key {
            list.extend(self.columns.blocks[block].columns.clone());
        }
        let score = self.score_columns(&list);
        self.known.insert(key, score);
        score
    }

    /// Held-out score of any columns (the baseline's must be among them).
    pub fn score_columns(&self, list: &[usize]) -> Score {
        let mut score = Score {
            squares: 0.0,
            fold: [0.0; FOLDS],
            log_evidence: 0.0,
        };
        for f in 0..FOLDS {
            match solve(&self.training[f], list, &self.gram.centre, 1.0) {
                Some(fit) => {
                    let first = self.columns.blocks[0].columns.end;
                    let largest = fit
                        .columns
                        .iter()
                        .zip(fit.amount.iter())
                        .filter(|(c, _)| **c >= first);
                    if largest.map(|(_, a)| a.abs()).fold(0.0, f64::max) > IMPLAUSIBLE {
                        score.squares = f64::INFINITY;
                        return Score {
                            fold: [f64::INFINITY; FOLDS],
                            log_evidence: f64::NEG_INFINITY,
                            ..score
                        };
                    }
                    score.fold[f] = squares(&self.gram.fold[f], &fit);
                    score.log_evidence += fit.log_evidence / (FOLDS - 1) as f64;
                }
                None => score.fold[f] = f64::INFINITY,
            }
            score.squares += score.fold[f];
        }
        // Below the noise: the columns hold the noise itself.
        if list.len() > self.columns.blocks[0].columns.len()
            && score.squares < TOO_GOOD * self.rows()
            && !self.overstated()
        {
            return Score {
                squares: f64::INFINITY,
                fold: [f64::INFINITY; FOLDS],
                log_evidence: f64::NEG_INFINITY,
            };
        }
        score
    }
}

/// What the search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Blocks, by the share that they take.
    pub blocks: Vec<usize>,
    /// Share of the excess that is left.
    pub rest: f64,
}

/// Whitened squares beyond `floor`, as a share of those of the baseline.
pub fn rest(arena: &mut Arena, blocks: &[usize], floor: f64) -> f64 {
    let whole = arena.score(&[]).squares - floor;
    let left = arena.score(blocks).squares;
    // What is of no physical size explains nothing.
    if left.is_finite() {
        (left - floor) / whole.max(1e-9)
    } else {
        1.0
    }
}

/// True if `with` beats `without` on all but one fold and by more than chance.
fn steady(with: &Score, without: &Score) -> bool {
    let better = with
        .fold
        .iter()
        .zip(&without.fold)
        .filter(|(a, b)| a < b)
        .count();
    better + 1 >= FOLDS && without.squares - with.squares > MINIMUM_SQUARES
}

/// Forward choice with elimination and exchange. `handicap` is added to a block's rest when it competes.
pub fn search(
    arena: &mut Arena,
    candidates: &[usize],
    handicap: &dyn Fn(usize) -> f64,
    floor: f64,
) -> Found {
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..MOST {
        let before = rest(arena, &chosen, floor).max(1e-6);
        let best = candidates
            .iter()
            .filter(|c| !chosen.contains(c))
            .map(|&c| {
                let mut set = chosen.clone();
                set.push(c);
                (c, rest(arena, &set, floor), handicap(c))
            })
            .min_by(|a, b| (a.1 + a.2 * before).total_cmp(&(b.1 + b.2 * before)));
        let Some((block, after, _)) = best else { break };
        let mut set = chosen.clone();
        set.push(block);
        let (old, new) = (arena.score(&chosen), arena.score(&set));
        let gain = before - after;
        let large = gain > minimum_share(arena, &set) && gain > MINIMUM_OF_REST * before
            || chosen.is_empty() && gain > 0.05;
        if !large || !steady(&new, &old) {
            // Two that only help together: try the best pair before giving up.
            break;
        }
        chosen = improve(arena, set, candidates, handicap, floor);
    }
    order(arena, &mut chosen, floor);
    let rest = rest(arena, &chosen, floor);
    Found {
        blocks: chosen,
        rest,
    }
}

fn minimum_share(arena: &Arena, set: &[usize]) -> f64 {
    let flexible = set
        .iter()
        .any(|b| crate::judge::FLEXIBLE.contains(&arena.columns.blocks[*b].name.as_str()));
    if flexible {
        MINIMUM_SHARE_BESIDE_FLEXIBLE
    } else {
        MINIMUM_SHARE
    }
}

/// Drops what is not needed and exchanges what another does better, until nothing changes.
fn improve(
    arena: &mut Arena,
    mut set: Vec<usize>,
    candidates: &[usize],
    handicap: &dyn Fn(usize) -> f64,
    floor: f64,
) -> Vec<usize> {
    for _ in 0..6 {
        let mut changed = false;
        for at in 0..set.len() {
            if set.len() < 2 {
                break;
            }
            let mut less = set.clone();
            less.remove(at);
            let (with, without) = (rest(arena, &set, floor), rest(arena, &less, floor));
            if without - with < minimum_share(arena, &set)
                || without - with < MINIMUM_OF_REST * without
            {
                set = less;
                changed = true;
                break;
            }
        }
        for at in 0..set.len() {
            let now = rest(arena, &set, floor) + handicap(set[at]);
            let better = candidates
                .iter()
                .filter(|c| !set.contains(c))
                .map(|&c| {
                    let mut other = set.clone();
                    other[at] = c;
                    (c, rest(arena, &other, floor) + handicap(c))
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((c, value)) = better.filter(|b| b.1 < now - 0.003_f64.max(0.05 * now)) {
                let _ = value;
                set[at] = c;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    set
}

/// Sorts by what each takes beyond the others.
fn order(arena: &mut Arena, set: &mut [usize], floor: f64) {
    let mut keyed: Vec<(f64, usize)> = set
        .iter()
        .map(|&block| {
            let others: Vec<usize> = set.iter().copied().filter(|b| *b != block).collect();
            (rest(arena, &others, floor), block)
        })
        .collect();
    keyed.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (slot, (_, block)) in set.iter_mut().zip(keyed) {
        *slot = block;
    }
}
