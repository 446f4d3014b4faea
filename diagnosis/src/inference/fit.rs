//! A fit of columns with their priors, from their products.

use crate::design::gram::{Columns, Gram};
use crate::design::training::Training;
use nalgebra::DVector;
use normal_equations::symmetric::Symmetric;
use normal_equations::unit_priors::{self, Solution};

/// Fit of some columns with their priors, on a training Gram.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Columns in the model.
    pub columns: Vec<usize>,
    /// Amounts in prior deviations.
    pub coefficient: DVector<f64>,
    /// Logarithm of the marginal likelihood for unit noise, up to a constant of the data.
    pub log_evidence: f64,
    /// Half the logarithm of the determinant of the coefficients' precision, in prior deviations: what the evidence pays for their
    /// freedom (Occam's factor).
    pub half_log_determinant: f64,
}

/// Solves for the columns with unit normal priors about `centre`, noise variance `variance`.
pub fn solve(training: Training, columns: &[usize], centre: &[f64], variance: f64) -> Option<Fit> {
    let n = columns.len();
    let last = training.last();
    let precision = 1.0 / variance;
    let normal = training.lower(columns) * precision;
    let right = DVector::from_fn(n, |a, _| training.at(columns[a], last) * precision);
    let centres = columns.iter().map(|&c| centre[c]);
    let Solution {
        values: coefficient,
        factor,
        right,
    } = unit_priors::solve(normal, right, centres)?;
    let log_det = factor.half_log_determinant();
    let prior: f64 = columns.iter().map(|&c| centre[c] * centre[c]).sum();
    let log_evidence =
        0.5 * (right.dot(&coefficient) - prior - training.at(last, last) * precision) - log_det;
    Some(Fit {
        columns: columns.to_vec(),
        coefficient,
        log_evidence,
        half_log_determinant: log_det,
    })
}

/// Amounts of all columns, in prior deviations: what is held is known and leaves the residual, the others are fitted to what stays.
pub fn coefficients(gram: &Gram, columns: &Columns) -> Vec<f64> {
    let (held, free): (Vec<usize>, Vec<usize>) = (0..gram.width()).partition(|c| columns.held[*c]);
    let last = gram.width();
    let mut training = gram.training(None).formed();
    for &h in &held {
        let coefficient = gram.centre[h];
        for row in 0..last {
            let known = training[(row, h)] * coefficient;
            training[(row, last)] -= known;
        }
    }
    let mut out = gram.centre.clone();
    let fit = solve(Training::of(&training), &free, &gram.centre, 1.0);
    for (k, c) in free.into_iter().enumerate() {
        out[c] = fit.as_ref().map_or(0.0, |fit| fit.coefficient[k]);
    }
    out
}

/// Squared whitened residual of a fit on other data: the quadratic form of what it adds to the columns, and takes from the target.
pub fn squares(test: &Symmetric, fit: &Fit) -> f64 {
    let coefficients = fit
        .columns
        .iter()
        .copied()
        .zip(fit.coefficient.iter().copied());
    test.quadratic(coefficients.chain([(test.order() - 1, -1.0)]))
}
