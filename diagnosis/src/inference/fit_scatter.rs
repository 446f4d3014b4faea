//! What a fit's own uncertainty adds to held-out residuals where nothing is wrong.
//!
//! A fold is predicted from the others by amounts that they know only so well. Of whitened noise e the prediction leaves
//! e - X (b - b0), whose expected square is one a row and tr(G S) besides: G are the fold's products, S the covariance of the
//! amounts that the other folds give (Cook and Weisberg 1982, leverage of cases that were left out). With ample motion it is a few
//! rows. Where a part of the motion is like no other it is more than the noise, and no gap.

use crate::design::gram::Gram;
use normal_equations::cholesky::Factor;

/// Squares that are added to those of the noise, in units of its variance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedSquares {
    /// Expected.
    pub mean: f64,
    /// Standard deviation beyond that of the noise itself: of a quadratic form of normal numbers.
    pub deviation: f64,
}

/// Of a fit of these columns, each fold predicted from the others. Cost: cube of the columns a fold.
pub fn expected_squares(gram: &Gram, columns: &[usize]) -> ExpectedSquares {
    let (mut mean, mut square) = (0.0, 0.0);
    for (fold, test) in gram.fold.iter().enumerate() {
        let mut normal = gram.training(Some(fold)).lower(columns);
        (0..columns.len()).for_each(|c| normal[(c, c)] += 1.0);
        // What cannot be solved predicts nothing, and no set is held against it.
        let Some(factor) = Factor::new(normal) else {
            continue;
        };
        let leverage = test.block(columns, columns) * factor.inverse();
        mean += leverage.trace();
        square += leverage.dot(&leverage.transpose());
    }
    ExpectedSquares {
        mean,
        deviation: (4.0 * mean + 2.0 * square).max(0.0).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use std::cell::{Cell, RefCell};

    /// A baseline that one fold alone shows well: what is expected beyond the noise is what comes, over draws of noise alone, and
    /// scatters as much.
    #[test]
    fn noise_alone_leaves_what_is_expected() {
        const DRAWS: u64 = 200;
        const ROWS: usize = 400;
        let one = |seed: u64| {
            let rng = RefCell::new(ChaCha8Rng::seed_from_u64(seed));
            let count = Cell::new(0);
            let row = |_: &mut ChaCha8Rng| {
                count.set(count.get() + 1);
                let column = if count.get() <= ROWS { 10.0 } else { 0.2 };
                vec![column, 0.0, normal(&mut rng.borrow_mut())]
            };
            let synthetic_problem = SyntheticProblem::new(&[("none", &[1.0])], &row);
            let mut validation = synthetic_problem.cross_validation();
            let beyond = validation.score(&[]).squares - validation.rows();
            (
                beyond,
                expected_squares(validation.gram, &[0]),
                validation.rows(),
            )
        };
        let drawn: Vec<f64> = (0..DRAWS).map(|seed| one(seed).0).collect();
        let (_, expected, rows) = one(0);
        let mean = drawn.iter().sum::<f64>() / DRAWS as f64;
        // The noise's own squares scatter besides.
        let deviation = expected.deviation.hypot((2.0 * rows).sqrt());
        let error = deviation / (DRAWS as f64).sqrt();
        assert!(expected.mean > 300.0, "{expected:?}");
        assert!(
            (mean - expected.mean).abs() < 4.0 * error,
            "{mean}, {expected:?}"
        );
        let found = crate::algebra::statistics::deviation(&drawn);
        assert!(
            (found / deviation - 1.0).abs() < 0.25,
            "{found}, {deviation}"
        );
    }
}
