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

/// Amounts of some columns with normal priors about `centre` of some deviations, for unit noise. None where the equations cannot be solved.
pub fn solve_at(
    training: Training,
    columns: &[usize],
    centre: &[f64],
    deviations: &[f64],
) -> Option<DVector<f64>> {
    let deviations = DVector::from_column_slice(deviations);
    let mut normal = training.lower(columns);
    for (mut column, deviation) in normal.column_iter_mut().zip(&deviations) {
        column.component_mul_assign(&deviations);
        column *= *deviation;
    }
    let right = training.right(columns).component_mul(&deviations);
    let centres = columns.iter().zip(&deviations);
    let centres = centres.map(|(c, deviation)| centre[*c] / deviation);
    let solution = unit_priors::solve(normal, right, centres)?;
    Some(solution.values.component_mul(&deviations))
}

/// Squared whitened residual of amounts of some columns on other data: the quadratic form of what they add to the columns, and take from the target.
pub fn squares(test: &Symmetric, columns: &[usize], amounts: &DVector<f64>) -> f64 {
    let amounts = columns.iter().copied().zip(amounts.iter().copied());
    test.quadratic(amounts.chain([(test.order() - 1, -1.0)]))
}
