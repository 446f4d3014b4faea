//! Held-out squares of sets of columns: what sets of effects are compared by.

use crate::data::folds::FOLDS;
use crate::design::errors_in_variables::ErrorsInVariables;
use crate::design::gram::{Columns, Gram};
use crate::inference::fit::{Fit, solve_at, squares};
use crate::inference::fit_scatter::{ExpectedSquares, expected_squares};
use crate::inference::schur::EliminatedBase;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// Sets are compared on these.
pub struct CrossValidation<'a> {
    /// Products of the columns.
    pub gram: &'a Gram,
    /// The columns.
    pub columns: &'a Columns,
    errors_in_variables: &'a ErrorsInVariables,
    known: HashMap<Vec<usize>, Score>,
    bases: HashMap<Option<usize>, EliminatedBase>,
    /// Held-out squares below which columns hold the noise itself.
    smallest_plausible: f64,
}

/// Held-out squares of a set of columns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Whitened squares over all folds, each predicted from the others.
    pub squares: f64,
    /// The same by fold.
    pub fold: [f64; FOLDS],
    /// Logarithm of the marginal likelihood of all rows for unit noise, up to a constant of the data: the shares
    /// of all folds together.
    pub log_evidence: f64,
}

/// Amounts beyond this many prior deviations off their means are of no physical size, however well they fit: each, or of very
/// many that have one size together their rms. A prior: sizes are stated as orders of magnitude, and 30 times 3 µm would be a
/// tenth of a tooth.
const IMPLAUSIBLE_PRIOR_DEVIATIONS: f64 = 30.0;
/// No held-out model beats the noise: below this share of it, and where the baseline does not, it is an artefact.
const TOO_GOOD_SHARE: f64 = 0.3;
/// Where the baseline leaves no more than this much of the noise, the stated noise is right, and chance bounds what is possible:
/// so many standard deviations of a sum of squares, and at least this share.
/// By definition: the square of what is called louder noise.
const NO_GAP_MEAN_SQUARE: f64 = 1.21;
/// Standard deviations of a sum of squares by which chance bounds what is possible there. Derived from the normal tail: by chance
/// once in 740 on this side.
const NO_GAP_DEVIATIONS: f64 = 3.0;
/// See [`NO_GAP_MEAN_SQUARE`].
const NO_GAP_LEAST_SHARE: f64 = 0.95;
impl<'a> CrossValidation<'a> {
    /// Sets are scored as they are asked for.
    pub fn new(
        gram: &'a Gram,
        columns: &'a Columns,
        errors_in_variables: &'a ErrorsInVariables,
    ) -> Self {
        let mut this = Self {
            gram,
            columns,
            errors_in_variables,
            known: HashMap::new(),
            bases: HashMap::new(),
            smallest_plausible: 0.0,
        };
        let base: Vec<usize> = columns.blocks[0].columns.clone().collect();
        if !gram.overstated {
            let baseline = this.score_columns(&base).squares;
            this.smallest_plausible = smallest_plausible(baseline, this.rows(), gram.loud);
        }
        this
    }

    /// Number of rows.
    pub fn rows(&self) -> f64 {
        self.gram.total_rows() as f64
    }

    /// Held-out score of the baseline with some blocks.
    pub fn score(&mut self, blocks: &[usize]) -> Score {
        let mut key = blocks.to_vec();
        key.sort_unstable();
        key.dedup();
        if let Some(score) = self.known.get(&key) {
            return *score;
        }
        let score = self.score_columns(&self.list(&key));
        self.known.insert(key, score);
        score
    }

    /// Held-out squares of the baseline with some blocks, each with the deviation of its amounts over the noise's, in prior deviations.
    /// Infinite where a fold's equations cannot be solved. Cost: cube of the columns a fold; nothing is kept.
    pub fn squares_at(&self, sizes: &[(usize, f64)]) -> f64 {
        let blocks = [(0, 1.0)].into_iter().chain(sizes.iter().copied());
        let columns = |b: usize| self.columns.blocks[b].columns.clone();
        let each = blocks.flat_map(|(b, size)| columns(b).map(move |c| (c, size)));
        let (list, deviations): (Vec<usize>, Vec<f64>) = each.unzip();
        let of_fold = |f: usize| {
            let training = self.gram.training(Some(f));
            let amounts = solve_at(training, &list, &self.gram.centre, &deviations)?;
            let left = squares(&self.gram.fold[f], &list, &amounts);
            let noise = squares(self.errors_in_variables.products(), &list, &amounts);
            Some(left - self.gram.rows[f] as f64 * self.errors_in_variables.allowance(noise))
        };
        let each: Vec<Option<f64>> = (0..FOLDS).into_par_iter().map(of_fold).collect();
        let all: Option<f64> = each.into_iter().sum();
        all.unwrap_or(f64::INFINITY)
    }

    /// Squares that the uncertainty of the amounts adds to the held-out ones of the baseline with some blocks. Cost: cube of the columns a fold.
    pub fn expected(&self, blocks: &[usize]) -> ExpectedSquares {
        expected_squares(self.gram, &self.list(blocks))
    }

    /// Number of columns of the baseline with some blocks.
    pub fn columns_of(&self, blocks: &[usize]) -> usize {
        self.list(blocks).len()
    }

    /// Columns of the baseline with some blocks.
    fn list(&self, blocks: &[usize]) -> Vec<usize> {
        let all = [0].iter().chain(blocks);
        all.flat_map(|b| self.columns.blocks[*b].columns.clone())
            .collect()
    }

    /// Held-out score of any columns (the baseline's must be among them).
    pub fn score_columns(&mut self, list: &[usize]) -> Score {
        let key = self.largest_block(list);
        if !self.bases.contains_key(&key) {
            let base = self.base(key);
            self.bases.insert(key, base);
        }
        let baseline = &self.columns.blocks[0].columns;
        let Some(base) = self.bases.get_mut(&key) else {
            return IMPOSSIBLE;
        };
        let shared = key.map(|b| &self.columns.blocks[b].columns);
        let more: Vec<usize> = list
            .iter()
            .copied()
            .filter(|c| !baseline.contains(c) && shared.is_none_or(|s| !s.contains(c)))
            .collect();
        let mut score = Score::default();
        let found = base.scores(self.gram, self.errors_in_variables.products(), &more);
        for (f, found) in found.into_iter().enumerate() {
            let Some((fit, left, noise)) = found else {
                return IMPOSSIBLE;
            };
            if self.implausible(&fit.columns, fit.coefficient.as_slice(), shared) {
                return IMPOSSIBLE;
            }
            score.fold[f] =
                left - self.gram.rows[f] as f64 * self.errors_in_variables.allowance(noise);
            score.log_evidence += self.share_of_evidence(&fit);
            score.squares += score.fold[f];
        }
        // Below the noise: the columns hold the noise itself.
        if list.len() > baseline.len() && score.squares < self.smallest_plausible {
            return IMPOSSIBLE;
        }
        score
    }

    /// What a fold's training sums say of the logarithm of the marginal likelihood of all rows. With coefficients `w` in prior deviations
    /// about means `c`, and products `G`, that is `-squares / 2 - |w - c|² / 2 - ln det(1 + G) / 2` (MacKay 1992). Each row is in the
    /// training sums of all folds but one, so the squares of all folds are those of all rows times `FOLDS - 1`. The prior's term and
    /// Occam's do not grow with the rows, but for a fraction of one a column: of them the mean of the folds counts.
    fn share_of_evidence(&self, fit: &Fit) -> f64 {
        let off = |(c, coefficient): (&usize, &f64)| (coefficient - self.gram.centre[*c]).powi(2);
        let prior: f64 = fit
            .columns
            .iter()
            .zip(fit.coefficient.iter())
            .map(off)
            .sum();
        let freedom = -0.5 * prior - fit.half_log_determinant;
        let of_squares = fit.log_evidence - freedom;
        of_squares / (FOLDS - 1) as f64 + freedom / FOLDS as f64
    }

    /// True if an effect's amounts are of no physical size. Of a block of very many, which have one size together, it is their rms
    /// that counts: one of them may be where hardly anything was seen.
    fn implausible(
        &self,
        columns: &[usize],
        coefficients: &[f64],
        many: Option<&Range<usize>>,
    ) -> bool {
        let baseline = &self.columns.blocks[0].columns;
        let (mut largest, mut squares, mut count) = (0.0f64, 0.0, 0.0);
        for (c, coefficient) in columns.iter().zip(coefficients) {
            let off = (coefficient - self.gram.centre[*c]).abs();
            if many.is_some_and(|many| many.contains(c)) {
                squares += off * off;
                count += 1.0;
            } else if !baseline.contains(c) {
                largest = largest.max(off);
            }
        }
        largest > IMPLAUSIBLE_PRIOR_DEVIATIONS
            || squares > IMPLAUSIBLE_PRIOR_DEVIATIONS * IMPLAUSIBLE_PRIOR_DEVIATIONS * count
    }

    /// The largest block that a list holds the whole of, where eliminating it once is worth the memory.
    fn largest_block(&self, list: &[usize]) -> Option<usize> {
        let blocks = self.columns.blocks.iter().enumerate().skip(1);
        blocks
            .filter(|(_, b)| {
                let of_it = || list.iter().filter(|c| b.columns.contains(c)).count();
                b.columns.len() >= ELIMINATED_ONCE_FROM && of_it() == b.columns.len()
            })
            .max_by_key(|(_, b)| b.columns.len())
            .map(|(k, _)| k)
    }

    fn base(&self, key: Option<usize>) -> EliminatedBase {
        let blocks = [Some(0), key].into_iter().flatten();
        let columns: Vec<usize> = blocks
            .flat_map(|b| self.columns.blocks[b].columns.clone())
            .collect();
        EliminatedBase::new(self.gram, &columns)
    }
}

/// Of what cannot be solved or is of no physical size.
const IMPOSSIBLE: Score = Score {
    squares: f64::INFINITY,
    fold: [f64::INFINITY; FOLDS],
    log_evidence: f64::NEG_INFINITY,
};
/// Columns from which a block is eliminated once for all sets that hold it. Cost alone: below, to keep the factor costs more
/// memory than it saves time.
const ELIMINATED_ONCE_FROM: usize = 120;

/// Held-out squares below which columns hold a reading's own noise, as an angle that hardly changes times large amounts does.
/// Noise that was found and not stated bounds nothing so closely.
fn smallest_plausible(baseline: f64, rows: f64, loud: bool) -> f64 {
    if baseline < 2.0 * TOO_GOOD_SHARE * rows {
        0.0
    } else if baseline < NO_GAP_MEAN_SQUARE * rows && !loud {
        rows * NO_GAP_LEAST_SHARE.min(1.0 - NO_GAP_DEVIATIONS * (2.0 / rows).sqrt())
    } else {
        TOO_GOOD_SHARE * rows
    }
}

#[cfg(test)]
mod tests {
    use crate::data::folds::FOLDS;
    use crate::inference::fit::solve;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// Rows are counted once, and so are the prior and what is paid for freedom. The rows that a fold lacks change two things, each by a
    /// number a column that does not grow with the rows: half a logarithm of the precision, and an eighth of a square, since each fold's own
    /// fit takes of its rows' noise what the fit of all rows does not (a fifth of a square, five times, over four, and halved).
    #[test]
    fn evidence_is_that_of_all_rows() {
        const COUNT: usize = 20;
        let problem = SyntheticProblem::new(&[("block", &[1.0; COUNT])], &|rng| {
            let mut row = vec![1.0];
            row.extend((0..COUNT).map(|_| normal(rng)));
            row.push(0.3 * row[1] + normal(rng));
            row
        });
        let mut validation = problem.cross_validation();
        let all: Vec<usize> = (0..=COUNT).collect();
        let gram = validation.gram;
        let exact = solve(gram.training(None), &all, &gram.centre, 1.0).unwrap();
        let columns = all.len() as f64;
        let fewer = columns * (0.5 * (FOLDS as f64 / (FOLDS - 1) as f64).ln() + 0.125);
        let told = validation.score(&[1]).log_evidence;
        // Counted a quarter more, Occam's factor alone would be off by far more than the tolerance.
        assert!(0.25 * exact.half_log_determinant > 10.0);
        let off = told - fewer - exact.log_evidence;
        // Three standard deviations of an eighth of a chi-square.
        assert!(off.abs() < 3.0 * 0.125 * (2.0 * columns).sqrt(), "{off}");
    }

    /// One amount of fifty prior deviations: no effect of that size, and one of a field's many.
    #[test]
    fn of_very_many_amounts_one_may_be_large() {
        let squares = |count: usize| {
            let sizes = vec![1.0; count];
            let synthetic_problem = SyntheticProblem::new(&[("block", &sizes[..])], &|rng| {
                let mut row = vec![1.0];
                row.extend((0..count).map(|_| 0.1 * normal(rng)));
                row.push(50.0 * row[1] + normal(rng));
                row
            });
            synthetic_problem.cross_validation().score(&[1]).squares
        };
        assert!(squares(2).is_infinite());
        assert!(squares(super::ELIMINATED_ONCE_FROM).is_finite());
    }
}
