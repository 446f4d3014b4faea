//! Which columns explain the gap: cross-validated residuals of sets of effects, forward, backward and by exchange.

use crate::inference::cross_validation::CrossValidation;
use crate::selection::core_terms::lacks_core_terms;
use crate::selection::limits::{MINIMUM_SQUARES, VISIBLE_GAP_RATIO};
use crate::selection::worth::{
    SEARCH_COMPLETING_SHARE, is_flexible, steady, unexplained_fraction, worth,
};

/// Most effects in one answer. By definition of the answer (`docs/formulation.md`): up to four.
const MOST_EFFECTS: usize = 4;

/// What the search found.
#[derive(Clone, Debug)]
pub struct SearchResult {
    /// Blocks, by the share that they take.
    pub blocks: Vec<usize>,
    /// Share of the excess that is left.
    pub unexplained_fraction: f64,
}

/// True if some block stands out beyond chance although the sum of squares does not: it leaves less than the baseline alone, and is
/// likelier. Large amounts that nearly cancel may leave less by the noise that they are allowed for. What it takes below the floor
/// is no gap: the simulator leaves as much.
pub fn stands_out(validation: &mut CrossValidation, floor: f64) -> bool {
    let alone = validation.score(&[]);
    (1..validation.columns.blocks.len()).any(|b| {
        let with = validation.score(&[b]);
        let gain = alone.squares - with.squares.max(floor);
        gain > 2.0 * MINIMUM_SQUARES
            && gain > 0.01 * floor
            && with.log_evidence > alone.log_evidence
    })
}

/// Held-out squares of the best that columns can do if only chance and likelihood bound their number: what is left is the noise.
pub fn noise_floor(validation: &mut CrossValidation, candidates: &[usize]) -> f64 {
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..MOST_EFFECTS {
        let Some(set) = with_best(validation, &chosen, candidates, &|_| 0.0, 0.0) else {
            break;
        };
        let (old, new) = (validation.score(&chosen), validation.score(&set));
        if !steady(&new, &old) || new.log_evidence <= old.log_evidence {
            break;
        }
        chosen = set;
    }
    validation.score(&chosen).squares
}

/// The set with the one candidate that leaves least, those that stand on completing terms aside.
fn with_best(
    validation: &mut CrossValidation,
    chosen: &[usize],
    candidates: &[usize],
    complexity_penalty: &dyn Fn(usize) -> f64,
    floor: f64,
) -> Option<Vec<usize>> {
    let before = unexplained_fraction(validation, chosen, floor).max(1e-6);
    let mut ranked: Vec<(f64, usize)> = candidates
        .iter()
        .filter(|c| !chosen.contains(c))
        .map(|&c| {
            let set: Vec<usize> = chosen.iter().copied().chain([c]).collect();
            (
                unexplained_fraction(validation, &set, floor) + complexity_penalty(c) * before,
                c,
            )
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = ranked
        .into_iter()
        .take(RANKED_CANDIDATES)
        .find(|(_, c)| !lacks_core_terms(validation, chosen, *c))?;
    Some(chosen.iter().copied().chain([best.1]).collect())
}

/// Candidates that are asked for their core before a place is given up. A bound on the work: what is no core among the first five
/// is not asked, and the place is given up.
const RANKED_CANDIDATES: usize = 5;
/// Forward choice with elimination and exchange. `complexity_penalty` is added to a block's rest when it competes.
pub fn search(
    validation: &mut CrossValidation,
    candidates: &[usize],
    complexity_penalty: &dyn Fn(usize) -> f64,
    floor: f64,
) -> SearchResult {
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..MOST_EFFECTS {
        let single = with_best(validation, &chosen, candidates, complexity_penalty, floor)
            .filter(|set| worth(validation, set, &chosen, floor));
        let Some(set) = single
            .or_else(|| best_pair(validation, &chosen, candidates, complexity_penalty, floor))
        else {
            break;
        };
        let set = improve(validation, set, candidates, complexity_penalty, floor);
        if validation.score(&set).squares >= validation.score(&chosen).squares {
            break;
        }
        chosen = set;
    }
    order(validation, &mut chosen, floor);
    let unexplained_fraction = unexplained_fraction(validation, &chosen, floor);
    SearchResult {
        blocks: chosen,
        unexplained_fraction,
    }
}

/// Candidates that are tried in twos where none helps by itself. A bound on the work: two of which one is no sixth by itself are
/// not found together.
const PAIRED_CANDIDATES: usize = 6;
/// Two that only help together must leave no more than this share of what was there.
const PAIR_LEAVES: f64 = 0.1;

/// The two that together explain nearly all of what neither explains alone.
fn best_pair(
    validation: &mut CrossValidation,
    chosen: &[usize],
    candidates: &[usize],
    complexity_penalty: &dyn Fn(usize) -> f64,
    floor: f64,
) -> Option<Vec<usize>> {
    let before = unexplained_fraction(validation, chosen, floor);
    // Two that only help together nearly cancel, and may be what another's shape lacks: they are believed where they take nearly
    // all of what is left. Where that is less than the stated noise, nobody can tell.
    if before <= 0.0 {
        return None;
    }
    let mut alone: Vec<(f64, usize)> = candidates
        .iter()
        .filter(|c| !chosen.contains(c))
        .map(|&c| {
            let set: Vec<usize> = chosen.iter().copied().chain([c]).collect();
            (
                unexplained_fraction(validation, &set, floor) + complexity_penalty(c) * before,
                c,
            )
        })
        .collect();
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    alone.truncate(PAIRED_CANDIDATES);
    alone.retain(|a| !lacks_core_terms(validation, chosen, a.1));
    let mut best: Option<(f64, Vec<usize>)> = None;
    for (k, one) in alone.iter().enumerate() {
        for other in &alone[k + 1..] {
            let set: Vec<usize> = chosen.iter().copied().chain([one.1, other.1]).collect();
            let value = unexplained_fraction(validation, &set, floor);
            if best.as_ref().is_none_or(|b| value < b.0) {
                best = Some((value, set));
            }
        }
    }
    let (value, set) = best?;
    (value < PAIR_LEAVES * before && worth(validation, &set, chosen, floor)).then_some(set)
}

/// Drops what is not needed and exchanges what another does better, until nothing changes.
fn improve(
    validation: &mut CrossValidation,
    mut set: Vec<usize>,
    candidates: &[usize],
    complexity_penalty: &dyn Fn(usize) -> f64,
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
            if !worth(validation, &set, &less, floor) {
                set = less;
                changed = true;
                break;
            }
        }
        for at in 0..set.len() {
            changed |= exchange(
                validation,
                &mut set,
                at,
                candidates,
                complexity_penalty,
                floor,
            );
        }
        if !changed {
            break;
        }
    }
    set
}

/// Puts a better block in the place of one, if there is one.
fn exchange(
    validation: &mut CrossValidation,
    set: &mut [usize],
    at: usize,
    candidates: &[usize],
    complexity_penalty: &dyn Fn(usize) -> f64,
    floor: f64,
) -> bool {
    let others: Vec<usize> = set.iter().copied().filter(|b| *b != set[at]).collect();
    // What there is to be taken in this place: a small effect's rivals are weighed by it as a large one's are.
    let stake = unexplained_fraction(validation, &others, floor).max(1e-6);
    let left = unexplained_fraction(validation, set, floor);
    let mut best = (0.0, set[at]);
    for &c in candidates.iter().filter(|c| !set.contains(c)) {
        let mut other = set.to_vec();
        other[at] = c;
        let (mut own, mut theirs) = (complexity_penalty(set[at]), complexity_penalty(c));
        if closes_what_shows(validation, set, &other, floor) {
            own = own.min(theirs);
        } else if closes_what_shows(validation, &other, set, floor) {
            theirs = theirs.min(own);
        }
        let now = left + own * stake;
        let gain = now - (unexplained_fraction(validation, &other, floor) + theirs * stake);
        let least = (0.003 * stake).max(0.05 * now);
        if gain > least && gain > best.0 {
            best = (gain, c);
        }
    }
    let changed = best.1 != set[at] && !lacks_core_terms(validation, &others, best.1);
    if !changed {
        return false;
    }
    set[at] = best.1;
    true
}

/// Left over a row, beyond the noise and relative to it, from which a gap shows.
const VISIBLE_EXCESS: f64 = VISIBLE_GAP_RATIO * VISIBLE_GAP_RATIO - 1.0;

/// True if a set closes nearly all of a gap that shows after another, and is the likelier of the two. What gives way to a cause is
/// then not asked to: a cause's model is inexact, but what it lacks would be left by the shape as well.
fn closes_what_shows(
    validation: &mut CrossValidation,
    set: &[usize],
    other: &[usize],
    floor: f64,
) -> bool {
    let (with, without) = (validation.score(set), validation.score(other));
    let shows = VISIBLE_EXCESS * validation.rows();
    let gap = without.squares - floor;
    !is_flexible(validation, set)
        && gap > shows
        && with.squares - floor < shows.max((1.0 - SEARCH_COMPLETING_SHARE) * gap)
        && with.log_evidence > without.log_evidence
}

/// Sorts by what each takes beyond the others.
fn order(validation: &mut CrossValidation, set: &mut [usize], floor: f64) {
    let mut keyed: Vec<(f64, usize)> = set
        .iter()
        .map(|&block| {
            let others: Vec<usize> = set.iter().copied().filter(|b| *b != block).collect();
            (unexplained_fraction(validation, &others, floor), block)
        })
        .collect();
    keyed.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (slot, (_, block)) in set.iter_mut().zip(keyed) {
        *slot = block;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::{ChaCha8Rng, normal};

    /// Two that nearly cancel beside one that is there: with the noise known they are found, below a noise that is stated too high
    /// they are not.
    #[test]
    fn two_that_cancel_are_not_believed_below_the_stated_noise() {
        let blocks = [("there", &[1.0][..]), ("one", &[1.0]), ("like it", &[1.0])];
        let synthetic_problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut draw = || normal(rng);
            let (there, both, apart, noise) = (draw(), draw(), draw(), draw());
            let target = there + 0.3 * apart + noise;
            vec![1.0, there, both + 0.3 * apart, both, target]
        });
        let found = |noise: f64| {
            let mut validation = synthetic_problem.cross_validation();
            let floor = noise * validation.rows();
            search(&mut validation, &[1, 2, 3], &|_| 0.0, floor).blocks
        };
        assert_eq!(found(1.0), [1, 2, 3]);
        assert_eq!(found(1.15), [1]);
    }

    /// Beside an effect that leaves less than the stated noise nothing is found: it may be the statement that is too high.
    #[test]
    fn below_the_stated_noise_nothing_is_put_beside_an_effect() {
        let blocks = [("there", &[1.0][..]), ("small", &[1.0])];
        let synthetic_problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut draw = || normal(rng);
            let (there, small, noise) = (draw(), draw(), draw());
            let target = 2.0 * there + 0.3 * small + noise;
            vec![1.0, there, small, target]
        });
        let found = |noise: f64| {
            let mut validation = synthetic_problem.cross_validation();
            let floor = noise * validation.rows();
            search(&mut validation, &[1, 2], &|_| 0.0, floor).blocks
        };
        assert_eq!(found(1.0), [1, 2]);
        assert_eq!(found(1.2), [1]);
    }

    /// A cause that a shape gives way to keeps its place unless it leaves a gap that shows where the shape leaves none.
    #[test]
    fn a_shape_gives_way_to_a_cause_unless_the_cause_leaves_a_gap() {
        let first = |lacks: f64| {
            let synthetic_problem =
                SyntheticProblem::new(&[("cause", &[1.0]), ("shape", &[1.0])], &|rng| {
                    let mut draw = || normal(rng);
                    let (shape, other, noise) = (draw(), draw(), draw());
                    vec![1.0, shape + lacks * other, shape, 3.0 * shape + noise]
                });
            let mut validation = synthetic_problem.cross_validation();
            let floor = validation.rows();
            let weight = |b: usize| if b == 2 { 0.1 } else { 0.0 };
            search(&mut validation, &[1, 2], &weight, floor).blocks
        };
        assert_eq!(first(0.05), [1]);
        assert_eq!(first(0.2), [2]);
    }

    /// Beside a great effect whose model is not exact to a thirtieth, one that takes nearly all of what is left is there, and one that
    /// takes a good part of it may be a stand-in.
    #[test]
    fn nearly_all_that_a_great_effect_leaves_is_an_effect() {
        let found = |like: f64| {
            let synthetic_problem =
                SyntheticProblem::new(&[("great", &[1.0]), ("small", &[1.0])], &|rng| {
                    let mut draw = || normal(rng);
                    let (great, lacks, small, other, noise) =
                        (draw(), draw(), draw(), draw(), draw());
                    let column = like * small + (1.0 - like * like).sqrt() * other;
                    let target = 20.0 * (great + 0.03 * lacks) + 3.0 * small + noise;
                    vec![1.0, great, column, target]
                });
            let mut validation = synthetic_problem.cross_validation();
            let floor = validation.rows();
            search(&mut validation, &[1, 2], &|_| 0.0, floor).blocks
        };
        assert_eq!(found(1.0), [1, 2]);
        assert_eq!(found(0.9), [1]);
    }

    /// What a field lacks is larger than what others do. One of few unknowns that takes most of what it leaves is there all the same.
    #[test]
    fn what_takes_most_of_what_a_field_leaves_is_an_effect() {
        let found = |first: &'static str, lag: f64, lacks: f64| {
            let synthetic_problem =
                SyntheticProblem::new(&[(first, &[1.0]), ("lag", &[1.0])], &|rng| {
                    let mut draw = || normal(rng);
                    let (field, lag_, else_, noise) = (draw(), draw(), draw(), draw());
                    let target = 20.0 * field + lag * lag_ + lacks * else_ + noise;
                    vec![1.0, field, lag_, target]
                });
            let mut validation = synthetic_problem.cross_validation();
            let floor = validation.rows();
            search(&mut validation, &[1, 2], &|_| 0.0, floor).blocks
        };
        assert_eq!(found("tooth_variation", 3.0, 1.2), [1, 2]);
        assert_eq!(found("tooth_variation", 1.2, 3.0), [1]);
        assert_eq!(found("great", 3.0, 1.2), [1]);
    }

    /// Noise stated a little too low. A shape that is there stands out; columns of nothing that carry much noise leave less by what
    /// that is allowed for, and do not.
    #[test]
    fn what_noise_is_allowed_for_does_not_stand_out() {
        const COLUMNS: usize = 20;
        let synthetic_problem = |there: f64, errors_in_variables: f64| {
            let row = |rng: &mut ChaCha8Rng| {
                let columns: Vec<f64> = (0..COLUMNS).map(|_| normal(rng)).collect();
                let target = there * columns[0] + 1.03 * normal(rng);
                [vec![1.0], columns, vec![target]].concat()
            };
            SyntheticProblem::new(&[("block", &[1.0; COLUMNS][..])], &row)
                .with_errors_in_variables(errors_in_variables)
        };
        let shape = synthetic_problem(0.4, 0.0);
        assert!(stands_out(
            &mut shape.cross_validation(),
            shape.cross_validation().rows()
        ));
        let nothing = synthetic_problem(0.0, 9.0);
        let mut validation = nothing.cross_validation();
        let gain = validation.score(&[]).squares - validation.score(&[1]).squares;
        assert!(gain > 2.0 * MINIMUM_SQUARES, "{gain}");
        let floor = validation.rows();
        assert!(!stands_out(&mut validation, floor));
        // Where the simulator leaves as much as the baseline alone there is no gap.
        let mut validation = shape.cross_validation();
        let floor = validation.score(&[]).squares;
        assert!(!stands_out(&mut validation, floor));
    }
}
