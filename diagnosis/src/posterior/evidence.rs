//! The probability of the data under a set of effects, its coefficients integrated out, with all constants.

use super::eliminated::Eliminated;
use super::reduced::Reduced;
use super::scale;
use super::size_likelihood::SizeLikelihood;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// A set at given sizes and noise.
#[derive(Clone, Debug)]
pub struct Given {
    /// Logarithm of the probability density of the whitened residuals, with every constant; of the baseline's flat prior the density is one
    /// a prior deviation.
    pub log_density: f64,
    /// Mean of the coefficients, in prior deviations.
    pub coefficients: DVector<f64>,
    /// Their precision, factored.
    pub eliminated: Eliminated,
    /// Sum of the variances of each block's coefficients.
    pub variances: Vec<f64>,
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
/// equations cannot be solved. Cost: the columns of the largest block times the square of the others'.
pub fn given(reduced: &Reduced, set: &[usize], log_variances: &[f64], noise: f64) -> Option<Given> {
    let eliminated = Eliminated::new(reduced, set, log_variances, noise)?;
    let At {
        list,
        amounts,
        explained,
        squares,
        log_density,
    } = At::new(reduced, set, log_variances, noise, &eliminated);
    let each = eliminated.variances();
    let (mut at, mut by_prior, mut penalty) = (0, 0.0, 0.0);
    let mut variances = Vec::new();
    for (block, size) in set.iter().zip(log_variances) {
        let own = reduced.blocks[*block].len();
        let variance = each.rows(at, own).sum();
        by_prior += variance * (-size).exp();
        penalty += amounts.rows(at, own).norm_squared() * (-size).exp();
        variances.push(variance);
        at += own;
    }
    Some(Given {
        log_density,
        squares: squares - noise * (explained + penalty),
        told: list.len() as f64 - by_prior,
        coefficients: amounts + DVector::from_fn(list.len(), |a, _| reduced.centre[list[a]]),
        eliminated,
        variances,
    })
}

/// The mean of a set's coefficients at given sizes and noise, and the density.
struct At {
    list: Vec<usize>,
    /// About the prior means.
    amounts: DVector<f64>,
    /// Squares over the noise that the mean takes off, less what the prior asks for it.
    explained: f64,
    /// Squares that the prior means leave.
    squares: f64,
    log_density: f64,
}

impl At {
    fn new(
        reduced: &Reduced,
        set: &[usize],
        log_variances: &[f64],
        noise: f64,
        eliminated: &Eliminated,
    ) -> Self {
        let list = reduced.columns(set);
        let (right, squares) = reduced.about_the_means(&list);
        let right = right / noise;
        let amounts = eliminated.solve(&right);
        let explained = right.dot(&amounts);
        let sizes = set.iter().zip(log_variances);
        let sizes: f64 = sizes
            .map(|(b, v)| reduced.blocks[*b].len() as f64 * v)
            .sum();
        let degrees = reduced.rows - reduced.baseline as f64;
        let constant = -0.5 * degrees * (TAU * noise).ln() - reduced.half_log_determinant;
        let freedom = eliminated.half_log_determinant + 0.5 * sizes;
        Self {
            log_density: constant - freedom - 0.5 * (squares / noise - explained),
            list,
            amounts,
            explained,
            squares,
        }
    }
}

/// Finds the sizes of a set from where they are thought to be, each with the others where they are, and integrates over them one by one.
/// Cost: for each effect some times that of [`given`], or the cube of its columns.
pub fn fitted(reduced: &Reduced, set: &[usize], start: &[f64], noise: f64) -> Option<Fitted> {
    let mut log_variances = start.to_vec();
    let mut widths = vec![0.0; set.len()];
    for k in 0..set.len() {
        let found = of_one(reduced, set, &log_variances, k, noise)?;
        (log_variances[k], widths[k]) = (found.mode, found.log_width);
    }
    at_sizes(reduced, set, log_variances, widths.iter().sum(), noise)
}

/// The size of one effect of a set, the others where they are.
fn of_one(
    reduced: &Reduced,
    set: &[usize],
    log_variances: &[f64],
    which: usize,
    noise: f64,
) -> Option<scale::Scale> {
    let count = |k: usize| reduced.blocks[set[k]].len();
    let (own, near) = (count(which), log_variances[which]);
    let others: usize = (0..set.len()).filter(|k| *k != which).map(count).sum();
    // Eliminated first, a block of many columns costs less at each size than it would to be told apart from the others.
    if reduced.in_own_axes && set.len() > 1 && own > MANY_TIMES * others {
        let density = |log_variance: f64| {
            let mut sizes = log_variances.to_vec();
            sizes[which] = log_variance;
            let eliminated = Eliminated::new(reduced, set, &sizes, noise);
            eliminated.map_or(f64::NEG_INFINITY, |e| {
                At::new(reduced, set, &sizes, noise, &e).log_density
            })
        };
        return Some(scale::about(near, own, density));
    }
    let likelihood = beside(reduced, set, log_variances, which, noise)?;
    let density = |log_variance: f64| likelihood.log_ratio(log_variance);
    Some(if set.len() == 1 {
        scale::integrate(own, density)
    } else {
        scale::about(near, own, density)
    })
}

/// Times as many columns as all others that an effect has from which on it is eliminated anew for each of some seven sizes.
/// Derived from both costs: that is `14 n m²`, telling it apart `4/3 n³`, and they are equal at n = 3.2 m.
const MANY_TIMES: usize = 3;

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
    let step = |(block, variance): (&usize, &f64)| {
        let columns = reduced.blocks[*block].clone();
        let count = columns.len();
        let square =
            |c: usize| (first.coefficients[at + c] - reduced.centre[columns.start + c]).powi(2);
        let squares = (0..count).map(square).sum::<f64>() + variance;
        at += count;
        scale::within((squares / count as f64).ln())
    };
    let sizes: Vec<f64> = set.iter().zip(&first.variances).map(step).collect();
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
    let likelihood = beside(reduced, &all, &sizes, set.len(), noise)?;
    let density = |log_variance: f64| likelihood.log_ratio(log_variance);
    let found = scale::integrate(likelihood.columns(), density);
    Some((density(found.mode) + found.log_width, found.mode))
}

/// How the density goes with one effect's size, the set's others eliminated with their priors.
fn beside(
    reduced: &Reduced,
    set: &[usize],
    log_variances: &[f64],
    which: usize,
    noise: f64,
) -> Option<SizeLikelihood> {
    let own = reduced.columns(&set[which..=which]);
    let rest: Vec<usize> = (0..set.len()).filter(|k| *k != which).collect();
    let rest_set: Vec<usize> = rest.iter().map(|k| set[*k]).collect();
    let rest_sizes: Vec<f64> = rest.iter().map(|k| log_variances[*k]).collect();
    let others = reduced.columns(&rest_set);
    let all: Vec<usize> = own.iter().chain(&others).copied().collect();
    let right = reduced.about_the_means(&all).0 / noise;
    let (own_right, rest_right) = (
        right.rows(0, own.len()),
        right.rows(own.len(), others.len()),
    );
    if others.is_empty() && reduced.in_own_axes {
        let diagonal = own.iter().map(|c| reduced.normal[(*c, *c)] / noise);
        return Some(SizeLikelihood::of_diagonal(diagonal.collect(), &right));
    }
    let mut normal = reduced.square(&own) / noise;
    if others.is_empty() {
        return Some(SizeLikelihood::new(&normal, &right));
    }
    let mut across = reduced.across(&others, &own) / noise;
    across = across.insert_column(own.len(), 0.0);
    across.set_column(own.len(), &rest_right);
    let half = Eliminated::new(reduced, &rest_set, &rest_sizes, noise)?.half(&across);
    let (across, target) = (half.columns(0, own.len()), half.column(own.len()));
    normal.gemm(-1.0, &across.transpose(), &across, 1.0);
    Some(SizeLikelihood::new(
        &normal,
        &(own_right - across.tr_mul(&target)),
    ))
}

#[cfg(test)]
mod tests;
