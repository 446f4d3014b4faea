//! Held-out pieces of the recording check a set, and can veto it: the evidence trusts the columns, of which some are formed of noisy
//! readings and rebuild noise where amounts nearly cancel; a piece that was not fitted shows that.

use super::weighed::Weighed;
use crate::inference::cross_validation::CrossValidation;

/// Share of what a set should predict of pieces that it was not fitted to, below which it is refuted. By definition: it is then more wrong about them
/// than right.
const PREDICTED_SHARE: f64 = 0.5;
/// Standard deviations of what noise does to held-out squares that are not asked for. Derived from the normal distribution, of which 95 % lie within.
const DEVIATIONS: f64 = 2.0;
/// Columns from which on it is not asked what noise does to the held-out squares of a set. A bound on the work: their cube is what that costs.
const MOST_COLUMNS: usize = 400;

/// The effect by which held-out pieces refute a set, told by its block: the one without which the others predict pieces that they were not fitted to best,
/// where they do so no worse than with it, or where the whole set predicts too little. `noise` is the variance at which the set was fitted. Cost: a
/// cross-validation for each effect and one of all; those that were asked for before are known.
pub fn refuted(validation: &mut CrossValidation, set: &Weighed, noise: f64) -> Option<usize> {
    let blocks = set.set();
    let each = blocks.iter().map(|block| {
        let others = blocks.iter().filter(|b| *b != block);
        (left(validation, others), *block)
    });
    let (without, block) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let whole = left(validation, blocks.iter());
    (without <= whole || predicts_too_little(validation, set, whole, noise)).then_some(block)
}

/// Held-out squares of a set.
fn left<'b>(validation: &mut CrossValidation, set: impl Iterator<Item = &'b usize>) -> f64 {
    validation.score(&in_the_columns(set)).squares
}

/// The blocks of a set among those of the columns, of which the baseline is the first.
fn in_the_columns<'b>(set: impl Iterator<Item = &'b usize>) -> Vec<usize> {
    set.map(|b| b + 1).collect()
}

/// True if a set predicts pieces that it was not fitted to by less than half of what it describes of those that it was: what it describes is no effect
/// of its columns then. Of squares `E` over the noise by `k` coefficients that the data tell, `E − k` are the effect's, and it should predict these less
/// what the uncertainty of its amounts adds to held-out squares beyond that of the baseline's (Cook and Weisberg 1982). Amounts that a fold's other
/// pieces do not tell are as large as the prior lets them, or as the largest size that was found. `left` are its held-out squares. Cost: nothing where it
/// predicts half of all that it describes; else the cube of its columns.
fn predicts_too_little(
    validation: &mut CrossValidation,
    set: &Weighed,
    left: f64,
    noise: f64,
) -> bool {
    let blocks = in_the_columns(set.set().iter());
    let predicted = validation.score(&[]).squares - left;
    let described = noise * (set.explained - set.fitted.given.told);
    if predicted >= PREDICTED_SHARE * described || validation.columns_of(&blocks) > MOST_COLUMNS {
        return false;
    }
    let [own, baseline] = [&blocks[..], &[]].map(|b| validation.expected(b));
    let sizes = set.fitted.log_variances.iter();
    let largest = sizes.fold(0.0_f64, |a, b| a.max(*b)).exp();
    let scatter = largest * (own.mean - baseline.mean) + DEVIATIONS * own.deviation;
    predicted < PREDICTED_SHARE * (described - scatter)
}

#[cfg(test)]
mod tests {
    use crate::posterior::problem::{Prior, Problem};
    use crate::posterior::sets::weigh;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;
    use std::cell::Cell;

    /// The effect by which held-out pieces refute the set of all effects.
    fn refuted(problem: &SyntheticProblem, set: &[usize]) -> Option<usize> {
        let numbers: Vec<usize> = (1..=set.len()).collect();
        let reduced = problem.reduced(&numbers);
        let effects: Vec<Prior> = set.iter().map(|b| Prior::of_cause(*b, 0.02)).collect();
        let all = weigh(&Problem::of_unit_noise(&reduced, &effects, -2.0));
        let whole = all.iter().find(|w| w.set() == set).unwrap();
        super::refuted(&mut problem.cross_validation(), whole, 1.0)
    }

    /// Thirty columns that do nothing predict no piece that they were not fitted to; a column that acts does, beside them or alone.
    #[test]
    fn what_does_not_act_is_vetoed() {
        let idle = [1.0; 30];
        let of = |blocks: &[(&'static str, &[f64])], idle: usize| {
            SyntheticProblem::new(blocks, &|rng| {
                let mut row = vec![1.0];
                row.extend((0..blocks.iter().map(|b| b.1.len()).sum()).map(|_| normal(rng)));
                let acts = if blocks.len() > idle {
                    row[1]
                } else {
                    normal(rng)
                };
                row.push(0.2 * acts + normal(rng));
                row
            })
        };
        let (acts, idle) = (("acts", &[1.0][..]), ("idle", &idle[..]));
        assert_eq!(refuted(&of(&[acts], 0), &[0]), None);
        assert_eq!(refuted(&of(&[idle], 1), &[0]), Some(0));
        assert_eq!(refuted(&of(&[acts, idle], 1), &[0, 1]), Some(1));
    }

    /// A column that acts by 2 in one piece of five and by so much in the others: a mean of both describes it, and predicts neither.
    fn of_a_column_that_varies(elsewhere: f64) -> Option<usize> {
        let count = Cell::new(0);
        let problem = SyntheticProblem::new(&[("acts", &[1.0])], &|rng| {
            count.set(count.get() + 1);
            let amount = if count.get() <= 400 { 2.0 } else { elsewhere };
            let column = normal(rng);
            vec![1.0, column, amount * column + normal(rng)]
        });
        refuted(&problem, &[0])
    }

    /// By 0.2 it describes 0.31 of a square a row, and predicts 0.02 of it; by 1.0 1.4 and 1.2.
    #[test]
    fn what_describes_pieces_and_predicts_none_is_refuted() {
        assert_eq!(of_a_column_that_varies(0.2), Some(0));
        assert_eq!(of_a_column_that_varies(1.0), None);
        assert_eq!(of_a_column_that_varies(2.0), None);
    }
}
