//! The best set of effects, beside the best set if shapes without a name may enter.

use crate::design::assembly::{BlockKind, Design, complexity_penalty};
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::core_terms::lacks_core_terms;
use crate::selection::search::{SearchResult, noise_floor, search};
use crate::selection::worth::{least_share, unexplained_fraction};
use crate::trace::{log, tracing};
use effects::{Card, Detection};

/// A shape without a name must do this much better than a cause, as a share of the gap.
const SHAPE_PENALTY: f64 = 0.02;
/// Blocks that stay in competition beside a field besides what was found. A bound on the work: beside hundreds of a field's
/// columns the others are not asked.
const LEADING_BLOCKS: usize = 5;

/// What the search told.
pub(super) struct SelectedModel {
    /// The best set of effects.
    pub(super) found: SearchResult,
    /// The best set if shapes may enter.
    pub(super) shaped: SearchResult,
    /// Whitened squares of the noise.
    pub(super) base: f64,
}

impl SelectedModel {
    /// Searches. Where the noise was found above the stated one, it is what the best shapes leave.
    pub(super) fn new(design: &Design, noisy: bool) -> Self {
        let mut validation = design.cross_validation();
        let coordinate_blocks = design.coordinate_blocks();
        let effects = design.effects();
        let all: Vec<usize> = effects.iter().chain(&coordinate_blocks).copied().collect();
        let stated = validation.rows() * design.floor.white_square;
        let base = if noisy {
            noise_floor(&mut validation, &all)
        } else {
            stated
        };
        let name = |b: usize| design.columns.blocks[b].name.as_str();
        let weight = |b: usize| {
            let shape = if coordinate_blocks.contains(&b) {
                SHAPE_PENALTY
            } else {
                0.0
            };
            complexity_penalty(name(b)) + shape
        };
        let mut found = search(&mut validation, &effects, &weight, base);
        simplify(&mut validation, &mut found, &effects, &weight, base);
        let shaped = search(&mut validation, &all, &weight, base);
        if tracing() {
            trace(design, &mut validation, &all, base);
            let mut next: Vec<(f64, &str)> = all
                .iter()
                .filter(|b| !found.blocks.contains(b))
                .map(|&b| {
                    let set: Vec<usize> = found.blocks.iter().copied().chain([b]).collect();
                    (unexplained_fraction(&mut validation, &set, base), name(b))
                })
                .collect();
            next.sort_by(|a, b| a.0.total_cmp(&b.0));
            next.truncate(6);
            log(&format!(
                "base {base:.0} of {:.0}; next {next:?}",
                validation.score(&[]).squares
            ));
        }
        let selected = |f: &SearchResult| f.blocks.iter().map(|b| name(*b)).collect::<Vec<_>>();
        log(&format!(
            "noisy {noisy}: found {:?} {:.4}; with shapes {:?} {:.4}",
            selected(&found),
            found.unexplained_fraction,
            selected(&shaped),
            shaped.unexplained_fraction
        ));
        Self {
            found,
            shaped,
            base,
        }
    }

    /// Whitened squares beyond the noise that what is found leaves.
    pub(super) fn left(&self, design: &Design) -> f64 {
        let mut validation = design.cross_validation();
        (validation.score(&self.found.blocks).squares - self.base).max(validation.rows())
    }

    /// Names of what is found.
    pub(super) fn names(&self, design: &Design) -> Vec<String> {
        let name = |b: &usize| design.columns.blocks[*b].name.clone();
        self.found.blocks.iter().map(name).collect()
    }
}

impl<'a> RelinearizedFit<'a> {
    /// What is found in a design, fitted about itself.
    pub(super) fn of(design: &Design<'a>, selected: &SelectedModel) -> Self {
        let names = selected.names(design);
        let point = LinearizationPoint {
            baseline: design.linearized.baseline.clone(),
            displacement: design.linearized.displacement.clone(),
            noise: None,
        };
        let relinearized = Self::new(&design.linearized, point, &names);
        log(&format!(
            "about itself: {:?} {:.3}",
            names,
            relinearized.residuals().white_rms()
        ));
        relinearized
    }
}

/// What leaves the same to within this share of what it takes is told apart by the number of unknowns alone.
const TIED_SHARE: f64 = 0.005;
/// One effect that leaves as little as two, to within this share of what they take, is to be believed.
const ONE_FOR_TWO_SHARE: f64 = 0.02;

/// Puts an effect of fewer unknowns in the place of one, or of two, that do no better.
fn simplify(
    validation: &mut CrossValidation,
    found: &mut SearchResult,
    candidates: &[usize],
    weight: &dyn Fn(usize) -> f64,
    base: f64,
) {
    let coordinate_blocks = 0..found.blocks.len();
    let pairs = coordinate_blocks
        .clone()
        .flat_map(|a| (0..a).map(move |b| vec![b, a]));
    let mut sets: Vec<Vec<usize>> = pairs.chain(coordinate_blocks.map(|a| vec![a])).collect();
    while let Some(set) = sets.pop() {
        let out: Vec<usize> = set.iter().map(|k| found.blocks[*k]).collect();
        let others: Vec<usize> = found
            .blocks
            .iter()
            .copied()
            .filter(|b| !out.contains(b))
            .collect();
        let allowance = if out.len() > 1 {
            ONE_FOR_TWO_SHARE
        } else {
            TIED_SHARE
        };
        let taken = unexplained_fraction(validation, &others, base) - found.unexplained_fraction;
        let unknowns = |b: usize| validation.columns.blocks[b].columns.len();
        let most: usize = out.iter().map(|b| unknowns(*b)).sum::<usize>() / (3 - out.len());
        let heaviest = out.iter().map(|b| weight(*b)).fold(0.0, f64::max);
        let simpler: Vec<usize> = candidates
            .iter()
            .copied()
            .filter(|c| !found.blocks.contains(c) && unknowns(*c) <= most && weight(*c) <= heaviest)
            .collect();
        let with = |c: usize| -> Vec<usize> { others.iter().copied().chain([c]).collect() };
        // What differs by less than an effect must take is told apart by the number of unknowns as well.
        let least = if out.len() > 1 {
            0.0
        } else {
            least_share(validation, base)
        };
        let allowed = (allowance * taken).max(least);
        let mut ranked: Vec<(f64, usize)> = simpler
            .into_iter()
            .map(|c| (unexplained_fraction(validation, &with(c), base), c))
            .filter(|b| b.0 - found.unexplained_fraction < allowed)
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        // One that stands on terms which only complete it is no simpler than two.
        let mut ranked = ranked.into_iter();
        let best = ranked.find(|b| out.len() == 1 || !lacks_core_terms(validation, &others, b.1));
        if let Some((left, c)) = best {
            log(&format!("one simpler: {c} for {out:?}"));
            *found = SearchResult {
                blocks: with(c),
                unexplained_fraction: left,
            };
            if out.len() > 1 {
                break;
            }
        }
    }
}

fn trace(design: &Design, validation: &mut CrossValidation, all: &[usize], base: f64) {
    let mut alone: Vec<(f64, &str)> = all
        .iter()
        .map(|&b| {
            (
                unexplained_fraction(validation, &[b], base),
                design.columns.blocks[b].name.as_str(),
            )
        })
        .collect();
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    let field = alone
        .iter()
        .position(|a| effects::is(a.1, Detection::AsField));
    let field = field.filter(|k| *k >= 6).map(|k| alone[k]);
    alone.truncate(6);
    alone.extend(field);
    log(&format!(
        "{} columns; alone {alone:?}",
        design.columns.regressors.len()
    ));
}

/// Blocks that stay in competition beside a field: what was found, and the best by themselves.
pub(super) fn leading(design: &Design, selected: &SelectedModel) -> Vec<String> {
    let mut validation = design.cross_validation();
    let mut alone: Vec<(f64, usize)> = (1..design.columns.blocks.len())
        .map(|b| (validation.score(&[b]).squares, b))
        .collect();
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What each does beside the field matters as well: a second effect may be any.
    let place = (1..design.columns.blocks.len()).filter(|b| {
        let name = design.columns.blocks[*b].name.as_str();
        let effect = matches!(design.kinds[*b - 1], BlockKind::Effect(_))
            && !effects::has(name, Card::is_flexible);
        crate::selection::limits::FIELD_COORDINATES.contains(&name)
            || effect
            || effects::is(name, Detection::AsField)
    });
    let mut list: Vec<usize> = selected.found.blocks.clone();
    list.extend(&selected.shaped.blocks);
    list.extend(alone.iter().take(LEADING_BLOCKS).map(|a| a.1));
    list.extend(place);
    list.sort_unstable();
    list.dedup();
    list.into_iter()
        .map(|b| design.columns.blocks[b].name.clone())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// A second unknown that takes less than an effect must take tells no effect from one without it.
    #[test]
    fn fewer_unknowns_are_believed_where_more_take_no_more_than_chance() {
        let left = |more: f64| {
            let blocks = [("eight", &[1.0, 1.0][..]), ("one", &[1.0])];
            let synthetic_problem = SyntheticProblem::new(&blocks, &|rng| {
                let mut draw = || normal(rng);
                let (one, other, noise) = (draw(), draw(), draw());
                vec![1.0, one, other, one, 0.3 * one + more * other + noise]
            });
            let mut validation = synthetic_problem.cross_validation();
            let base = validation.rows();
            let unexplained_fraction = unexplained_fraction(&mut validation, &[1], base);
            let blocks = vec![1];
            let mut found = SearchResult {
                blocks,
                unexplained_fraction,
            };
            simplify(&mut validation, &mut found, &[1, 2], &|_| 0.0, base);
            found.blocks
        };
        assert_eq!(left(0.05), [2]);
        assert_eq!(left(0.3), [1]);
    }

    /// One that does as well as two by what only completes it is not believed in their place.
    #[test]
    fn no_two_are_put_down_to_what_completes_a_third() {
        let left = |sizes: &[f64]| {
            let blocks = [("one", &[1.0][..]), ("other", &[1.0]), ("third", sizes)];
            let synthetic_problem = SyntheticProblem::new(&blocks, &|rng| {
                let mut draw = || normal(rng);
                let (one, other, else_, noise) = (draw(), draw(), draw(), draw());
                let target = one + other + noise;
                vec![1.0, one, other, else_, one + other, target]
            });
            let mut validation = synthetic_problem.cross_validation();
            let base = validation.rows();
            let unexplained_fraction = unexplained_fraction(&mut validation, &[1, 2], base);
            let blocks = vec![1, 2];
            let mut found = SearchResult {
                blocks,
                unexplained_fraction,
            };
            simplify(&mut validation, &mut found, &[1, 2, 3], &|_| 0.0, base);
            found.blocks
        };
        assert_eq!(left(&[1.0, 1.0]), [3]);
        assert_eq!(left(&[1.0, 0.2]), [1, 2]);
    }
}
