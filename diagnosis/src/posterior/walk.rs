//! The walk through the sets of up to four effects at one noise: all single effects, all pairs, and larger sets built upon the likeliest.

use super::evidence::{Fitted, fitted, roughly};
use super::problem::Problem;
use super::weighed::{Weighed, sort, weighed};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most effects in a set. By definition of the answer (`docs/formulation.md`): up to four.
pub const MOST: usize = 4;
/// Sets of each number of effects that are built upon. A bound on the work: a set of three whose pairs are all worse than the
/// sixth is not seen.
const BUILT_UPON: usize = 6;
/// Sets whose sizes are found together, with nameless shapes besides. A bound on the work: the others keep the sizes that each
/// effect has alone, which makes them no likelier.
const WITH_SHAPES: usize = 5;
/// Of an effect of more columns than this many are told by the prior, so that one step does not lead to its size.
const LARGE: usize = 120;

/// Weighs the sets at one noise, the likeliest first.
pub fn walk(problem: &Problem) -> Vec<Weighed> {
    let mut all = among(problem);
    let shown = shown(problem, &all);
    let exact: Vec<_> = shown
        .par_iter()
        .map(|k| exactly(problem, &all[*k].fitted))
        .collect();
    for (k, exact) in shown.iter().zip(exact) {
        if let Some(exact) = exact {
            all[*k] = exact;
        }
    }
    let mut place = 0..;
    all.retain(|w| {
        let looked_at = place.next().is_some_and(|k| shown.contains(&k));
        looked_at || w.set().len() < 2 || !holds_many(problem, w)
    });
    sort(&mut all, problem.log_odds);
    all
}

/// Those of the sets that were weighed at one noise which were looked at closely, to be weighed at another.
pub fn likeliest(problem: &Problem, all: &[Weighed]) -> Vec<Fitted> {
    let shown = shown(problem, all).into_iter();
    shown.map(|k| all[k].fitted.clone()).collect()
}

/// Weighs some sets closely, from sizes that they had at another noise; the likeliest first.
pub fn among_these(problem: &Problem, near: &[Fitted]) -> Vec<Weighed> {
    let mut all: Vec<Weighed> = near
        .par_iter()
        .filter_map(|f| exactly(problem, f))
        .collect();
    sort(&mut all, problem.log_odds);
    all
}

/// A set with its sizes found together, from where they are thought to be, and with the best nameless shapes beside it.
fn exactly(problem: &Problem, near: &Fitted) -> Option<Weighed> {
    let fitted = fitted(
        problem.reduced,
        &near.set,
        &near.log_variances,
        problem.noise,
    )?;
    let mut out = weighed(problem, fitted);
    out.look_for_lines(problem);
    out.look_for_shapes(problem);
    Some(out)
}

/// Places of the sets that are looked at closely: the likeliest of those that hold an effect of many columns, whose other sets are left
/// out, those that lack one effect of the likeliest of them, and the likeliest of those that hold none. The empty set always: without it
/// nothing is said of a gap that no effect explains.
fn shown(problem: &Problem, all: &[Weighed]) -> Vec<usize> {
    let likeliest = |many: bool| {
        let of_it = (0..all.len()).filter(move |k| holds_many(problem, &all[*k]) == many);
        of_it.take(WITH_SHAPES)
    };
    let empty = all.iter().position(|w| w.set().is_empty());
    let largest = likeliest(true).next();
    let lacks_one = |k: &usize| largest.is_some_and(|l| is_less_one(all[*k].set(), all[l].set()));
    let mut out: Vec<usize> = likeliest(false)
        .chain(likeliest(true))
        .chain((0..all.len()).filter(lacks_one))
        .chain(empty)
        .collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// True if a set is another without one of its effects.
fn is_less_one(set: &[usize], of: &[usize]) -> bool {
    set.len() + 1 == of.len() && set.iter().all(|b| of.contains(b))
}

/// True if one of its effects has many columns.
fn holds_many(problem: &Problem, weighed: &Weighed) -> bool {
    let columns = |b: &usize| problem.reduced.blocks[*b].len();
    weighed.set().iter().any(|b| columns(b) > LARGE)
}

/// The sets of up to [`MOST`] effects, their sizes found to first order; the likeliest first.
fn among(problem: &Problem) -> Vec<Weighed> {
    let mut known: BTreeMap<Vec<usize>, Weighed> = BTreeMap::new();
    let count = problem.effects.len();
    add(problem, &mut known, vec![Vec::new()]);
    add(problem, &mut known, (0..count).map(|e| vec![e]).collect());
    let pairs = (0..count).flat_map(|a| (0..a).map(move |b| vec![b, a]));
    add(problem, &mut known, pairs.collect());
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
    sort(&mut all, problem.log_odds);
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
    let Problem { reduced, noise, .. } = *problem;
    let blocks: Vec<usize> = set.iter().map(|e| problem.effects[*e].block).collect();
    let fitted = match alone {
        Some(alone) if set.len() > 1 => roughly(reduced, &blocks, alone, noise)?,
        None if set.len() > 1 => return None,
        _ => fitted(reduced, &blocks, &vec![0.0; set.len()], noise)?,
    };
    Some(weighed(problem, fitted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posterior::problem::Prior;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// The likeliest set of an effect of many columns, all of which act by so much, one other that acts, one that does not, and something
    /// that none of them explains.
    fn likeliest(large: f64, small: f64, rest: f64) -> Vec<usize> {
        let many = vec![1.0; LARGE + 1];
        let blocks = [("large", &many[..]), ("small", &[1.0]), ("idle", &[1.0])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut row = vec![1.0];
            row.extend((0..LARGE + 3).map(|_| normal(rng)));
            let sum: f64 = row[1..LARGE + 2].iter().sum();
            let left = rest * normal(rng) + normal(rng);
            row.push(large * sum + small * row[LARGE + 2] + left);
            row
        });
        let reduced = problem.reduced(&[1, 2, 3]);
        let prior = |block| Prior::of_cause(block, 0.05);
        let effects: Vec<Prior> = (0..3).map(prior).collect();
        let all = walk(&Problem::of_unit_noise(&reduced, &effects, -2.0));
        all[0].set().to_vec()
    }

    #[test]
    fn companions_of_an_effect_of_many_columns_are_found() {
        assert_eq!(likeliest(0.2, 0.5, 0.0), [0, 1]);
        assert_eq!(likeliest(0.2, 0.0, 0.0), [0]);
        assert_eq!(likeliest(0.0, 0.5, 0.0), [1]);
        // 121 columns at 1 explain 242,000 squares of 2,000 rows, of which a twentieth of the amplitude is 605. The companion does 180, and
        // is well seen; beside three times as much that stays as well, since what the large one's form lacks may lie in any of 80 directions.
        assert_eq!(likeliest(1.0, 0.3, 0.5), [0, 1]);
        assert_eq!(likeliest(1.0, 0.3, 0.0), [0, 1]);
        assert_eq!(likeliest(1.0, 1.0, 0.5), [0, 1]);
    }

    /// Beside an effect of many columns two others act, and six do not. Sets with one of the six besides are likelier than those without one of the
    /// two; these are compared all the same, since a smaller set may predict the same.
    #[test]
    fn sets_that_lack_one_effect_of_the_likeliest_are_compared() {
        const IDLE: usize = 6;
        let many = vec![1.0; LARGE + 1];
        let mut blocks = vec![("large", &many[..]), ("one", &[1.0]), ("other", &[1.0])];
        blocks.extend([("idle", &[1.0][..]); IDLE]);
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut row = vec![1.0];
            row.extend((0..LARGE + 3 + IDLE).map(|_| normal(rng)));
            let sum: f64 = row[1..LARGE + 2].iter().sum();
            row.push(0.2 * sum + row[LARGE + 2] + row[LARGE + 3] + normal(rng));
            row
        });
        let numbers: Vec<usize> = (1..=blocks.len()).collect();
        let reduced = problem.reduced(&numbers);
        let effects: Vec<Prior> = (0..blocks.len())
            .map(|block| Prior::of_cause(block, 0.05))
            .collect();
        let all = walk(&Problem::of_unit_noise(&reduced, &effects, -2.0));
        assert_eq!(all[0].set(), [0, 1, 2]);
        for set in [[0, 1], [0, 2]] {
            assert!(all.iter().any(|w| w.set() == set), "{set:?}");
        }
    }
}
