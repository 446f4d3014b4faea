//! The probability of the data under a set of effects, its coefficients integrated out, with all constants.

use super::reduced::Reduced;
use super::scale;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::f64::consts::TAU;

/// A set at given sizes and noise.
#[derive(Clone, Debug)]
pub struct Given {
    /// Logarithm of the probability density of the whitened residuals, with every constant; of the baseline's flat prior the density is one
    /// a prior deviation.
    pub log_density: f64,
    /// Mean of the coefficients, in prior deviations.
    pub coefficients: DVector<f64>,
    /// Inverse of the Cholesky factor of their precision.
    pub factor_inverse: DMatrix<f64>,
    /// Whitened squares that the mean leaves.
    pub squares: f64,
    /// Number of coefficients that the data tell, and not the prior.
    pub told: f64,
}

/// A set with its sizes found.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Blocks.
    pub set: Vec<usize>,
    /// Logarithm of each effect's variance over the stated one, at its likeliest.
    pub log_variances: Vec<f64>,
    /// At these sizes.
    pub given: Given,
    /// Logarithm of what integrating over the sizes adds to the density at their likeliest.
    pub log_widths: f64,
    /// Whitened squares that the fit adds to the noise, since its columns are formed of noisy readings.
    pub allowance: f64,
}

/// The set with each block's variance (over the stated one, as a logarithm) and the variance of the whitened noise. None where its
/// equations cannot be solved. Cost: the cube of its columns.
pub fn given(reduced: &Reduced, set: &[usize], log_variances: &[f64], noise: f64) -> Option<Given> {
    let list = reduced.columns(set);
    let (normal, right, squares) = reduced.about_the_means(&list);
    let degrees = reduced.rows - reduced.baseline as f64;
    let constant = -0.5 * degrees * (TAU * noise).ln() - reduced.half_log_determinant;
    let sizes = sizes(reduced, set, log_variances);
    let (mut precision, right) = (normal / noise, right / noise);
    (0..list.len()).for_each(|a| precision[(a, a)] += (-sizes[a]).exp());
    let factor = Factor::new(precision)?;
    let amounts = factor.solve(&right);
    let explained = right.dot(&amounts);
    let half_log_ratio = factor.half_log_determinant() + 0.5 * sizes.iter().sum::<f64>();
    let inverse = factor.lower_inverse();
    let off = amounts.iter().zip(&sizes);
    let penalty: f64 = off.map(|(a, size)| a * a * (-size).exp()).sum();
    let by_prior = (0..list.len()).map(|a| inverse.column(a).norm_squared() * (-sizes[a]).exp());
    Some(Given {
        log_density: constant - half_log_ratio - 0.5 * (squares / noise - explained),
        squares: squares - noise * (explained + penalty),
        told: list.len() as f64 - by_prior.sum::<f64>(),
        coefficients: amounts + DVector::from_fn(list.len(), |a, _| reduced.centre[list[a]]),
        factor_inverse: inverse,
    })
}

/// Finds the sizes of a set from where they are thought to be, each with the others where they are, and integrates over them one by one.
/// Cost: some three times the cube of each effect's columns and that of all.
pub fn fitted(reduced: &Reduced, set: &[usize], start: &[f64], noise: f64) -> Option<Fitted> {
    let mut log_variances = start.to_vec();
    let mut widths = vec![0.0; set.len()];
    for k in 0..set.len() {
        let (normal, right) = beside(reduced, set, &log_variances, k, noise)?;
        let likelihood = |log_variance: f64| log_ratio(&normal, &right, log_variance);
        let found = if set.len() == 1 {
            scale::integrate(right.len(), likelihood)
        } else {
            scale::about(log_variances[k], right.len(), likelihood)
        };
        (log_variances[k], widths[k]) = (found.mode, found.log_width);
    }
    at_sizes(reduced, set, log_variances, widths.iter().sum(), noise)
}

/// The same to first order, for a search: the sizes after one step of expectation and maximisation from where each effect has them alone,
/// and the widths of the integrals that it has alone. Cost: twice the cube of the columns.
pub fn roughly(
    reduced: &Reduced,
    set: &[usize],
    alone: &[(f64, f64)],
    noise: f64,
) -> Option<Fitted> {
    let start: Vec<f64> = alone.iter().map(|a| a.0).collect();
    let first = given(reduced, set, &start, noise)?;
    let mut at = 0;
    let step = |block: &usize| {
        let own = at..at + reduced.blocks[*block].len();
        at = own.end;
        let columns = reduced.blocks[*block].clone();
        let off = own.clone().zip(columns);
        let square = |(k, c): (usize, usize)| (first.coefficients[k] - reduced.centre[c]).powi(2);
        let spread: f64 = own
            .clone()
            .map(|k| first.factor_inverse.column(k).norm_squared())
            .sum();
        ((off.map(square).sum::<f64>() + spread) / own.len().max(1) as f64).ln()
    };
    let sizes: Vec<f64> = set.iter().map(step).collect();
    let change =
        |(size, alone): (&f64, &(f64, f64))| scale::log_prior(*size) - scale::log_prior(alone.0);
    let widths =
        alone.iter().map(|a| a.1).sum::<f64>() + sizes.iter().zip(alone).map(change).sum::<f64>();
    at_sizes(reduced, set, sizes, widths, noise)
}

fn at_sizes(
    reduced: &Reduced,
    set: &[usize],
    log_variances: Vec<f64>,
    log_widths: f64,
    noise: f64,
) -> Option<Fitted> {
    let given = given(reduced, set, &log_variances, noise)?;
    let list = reduced.columns(set);
    Some(Fitted {
        allowance: reduced.allowance(&list, &given.coefficients),
        set: set.to_vec(),
        log_variances,
        log_widths,
        given,
    })
}

/// Logarithm of what a further block adds to the evidence of a set whose sizes are known, and the logarithm of its own size.
pub fn gain(
    reduced: &Reduced,
    set: &[usize],
    log_variances: &[f64],
    more: usize,
    noise: f64,
) -> Option<(f64, f64)> {
    let all = [set, &[more]].concat();
    let sizes = [log_variances, &[0.0]].concat();
    let (normal, right) = beside(reduced, &all, &sizes, set.len(), noise)?;
    let likelihood = |log_variance: f64| log_ratio(&normal, &right, log_variance);
    let found = scale::integrate(right.len(), likelihood);
    Some((likelihood(found.mode) + found.log_width, found.mode))
}

/// Logarithm of the density with columns of this variance over that without, given their products over the noise.
pub fn log_ratio(normal: &DMatrix<f64>, right: &DVector<f64>, log_variance: f64) -> f64 {
    let n = right.len();
    let mut precision = normal.clone();
    (0..n).for_each(|a| precision[(a, a)] += (-log_variance).exp());
    let Some(factor) = Factor::new(precision) else {
        return f64::NEG_INFINITY;
    };
    let freedom = factor.half_log_determinant() + 0.5 * n as f64 * log_variance;
    0.5 * right.dot(&factor.solve(right)) - freedom
}

/// One effect's products over the noise, the set's others eliminated with their priors.
fn beside(
    reduced: &Reduced,
    set: &[usize],
    log_variances: &[f64],
    which: usize,
    noise: f64,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let own = reduced.columns(&set[which..=which]);
    let without = |k: &usize| *k != which;
    let rest: Vec<usize> = (0..set.len()).filter(without).collect();
    let rest_set: Vec<usize> = rest.iter().map(|k| set[*k]).collect();
    let rest_sizes: Vec<f64> = rest.iter().map(|k| log_variances[*k]).collect();
    let others = reduced.columns(&rest_set);
    let all: Vec<usize> = own.iter().chain(&others).copied().collect();
    let (_, right, _) = reduced.about_the_means(&all);
    let mut normal = reduced.square(&own) / noise;
    let mut own_right = right.rows(0, own.len()).into_owned() / noise;
    if !others.is_empty() {
        let across = reduced.across(&others, &own) / noise;
        let mut precision = reduced.square(&others) / noise;
        let sizes = sizes(reduced, &rest_set, &rest_sizes);
        (0..others.len()).for_each(|a| precision[(a, a)] += (-sizes[a]).exp());
        let half = Factor::new(precision)?.lower_inverse();
        let across = &half * across;
        let target = &half * right.rows(own.len(), others.len()) / noise;
        normal.gemm(-1.0, &across.transpose(), &across, 1.0);
        own_right -= across.tr_mul(&target);
    }
    Some((normal, own_right))
}

/// Logarithm of the variance of each column of a set.
fn sizes(reduced: &Reduced, set: &[usize], log_variances: &[f64]) -> Vec<f64> {
    let each = set.iter().zip(log_variances);
    each.flat_map(|(b, v)| reduced.blocks[*b].clone().map(move |_| *v))
        .collect()
}

#[cfg(test)]
mod tests;
