//! Held-out pieces of the recording check a set, and can veto it: the evidence trusts the columns, of which some are formed of noisy
//! readings and rebuild noise where amounts nearly cancel; a piece that was not fitted shows that.

use super::least_size::least_squares;
use super::noise_scale::Left;
use super::weighed::Weighed;
use crate::figures::limits::VISIBLE_GAP_RATIO;
use crate::inference::cross_validation::CrossValidation;

/// Share of what a set should predict of pieces that it was not fitted to, below which it is refuted. By definition: it is then more wrong about them
/// than right.
const PREDICTED_SHARE: f64 = 0.5;
/// Standard deviations of what noise does to held-out squares that are not asked for. Derived from the normal distribution, of which 95 % lie within.
const DEVIATIONS: f64 = 2.0;
/// Columns from which on it is not asked what noise does to the held-out squares of a set. A bound on the work: their cube is what that costs.
const MOST_COLUMNS: usize = 400;

/// The effect by which held-out pieces refute a set, told by its block: the one without which the others predict pieces that they were not
/// fitted to best, where they do so no worse than with it, or where the whole set predicts too little. `noise` is the variance at which the
/// set was fitted.
///
/// This is asked twice: with effects of the sizes that are usual before the data, and, where these refute the set, with effects of the sizes
/// that were found. Only a set that both refute is refuted. Teeth that are displaced by a thirtieth of the usual size need the second
/// question: fitted as if they were of the usual size, they rebuild so much noise that they predict nothing.
///
/// With the sizes that were found an effect must predict as many squares as are worth a name. An effect that does not act is found so small
/// that it does no harm, and predicts some squares by chance.
///
/// A set that leaves a gap by itself is asked the first question alone. It is not the true set, and its effects are found as large as they
/// must be to describe what another cause does.
///
/// Cost: a cross-validation for each effect and one of all; known scores cost nothing. The second question costs the same again, and no score of
/// it is kept.
pub fn refuted(validation: &mut CrossValidation, set: &Weighed, noise: f64) -> Option<usize> {
    let stated = |validation: &mut CrossValidation, blocks: &[usize]| {
        validation.score(&in_the_columns(blocks)).squares
    };
    let effect = refuted_at(validation, set, noise, 0.0, stated)?;
    if leaves_a_gap(&set.left) {
        return Some(effect);
    }
    let found = |validation: &mut CrossValidation, blocks: &[usize]| {
        let each = set.set().iter().zip(&set.fitted.log_variances);
        let asked = each.filter(|(b, _)| blocks.contains(b));
        let sizes: Vec<(usize, f64)> = asked
            .map(|(b, g)| (b + 1, (g.exp() / noise).sqrt()))
            .collect();
        validation.squares_at(&sizes)
    };
    let least = noise * least_squares(validation.rows());
    refuted_at(validation, set, noise, least, found)
}

/// True if a set leaves what would be a gap by itself, over the stated noise.
fn leaves_a_gap(left: &Left) -> bool {
    left.squares - left.allowance > VISIBLE_GAP_RATIO * VISIBLE_GAP_RATIO * left.degrees
}

/// The same by some held-out squares of blocks of the set, of which an effect must take off more than `least`.
fn refuted_at(
    validation: &mut CrossValidation,
    set: &Weighed,
    noise: f64,
    least: f64,
    left: impl Fn(&mut CrossValidation, &[usize]) -> f64,
) -> Option<usize> {
    let blocks = set.set();
    let each = blocks.iter().map(|block| {
        let others: Vec<usize> = blocks.iter().copied().filter(|b| b != block).collect();
        (left(validation, &others), *block)
    });
    let (without, block) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let whole = left(validation, blocks);
    (without <= whole + least || predicts_too_little(validation, set, whole, noise))
        .then_some(block)
}

/// The blocks of a set among those of the columns, of which the baseline is the first.
fn in_the_columns(set: &[usize]) -> Vec<usize> {
    set.iter().map(|b| b + 1).collect()
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
    let blocks = in_the_columns(set.set());
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

    /// Three hundred columns that each do a fiftieth of what is usual. At the usual size they rebuild more noise of a piece than they predict of it; at
    /// the size that is found they predict it. As many that do nothing are vetoed at any size, and so are those beside which a gap is left.
    #[test]
    fn what_is_small_predicts_at_its_own_size() {
        const COLUMNS: usize = 300;
        let of = |amount: f64, noise: f64| {
            SyntheticProblem::new(&[("acts", &[1.0; COLUMNS])], &|rng| {
                let columns: Vec<f64> = (0..COLUMNS).map(|_| normal(rng)).collect();
                let sum: f64 = columns.iter().sum();
                let target = amount * sum + noise * normal(rng);
                [&[1.0][..], &columns, &[target]].concat()
            })
        };
        let small = of(0.02, 1.0);
        let mut validation = small.cross_validation();
        assert!(validation.score(&[1]).squares > validation.score(&[]).squares);
        assert_eq!(refuted(&small, &[0]), None);
        assert_eq!(refuted(&of(0.0, 1.0), &[0]), Some(0));
        assert_eq!(refuted(&of(0.02, 1.2), &[0]), Some(0));
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
