//! Normal equations without the baseline: its coefficients are in every set, with a flat prior, and are eliminated once.
//!
//! Flat, because an effect must not be paid for relieving the baseline: with a proper prior, an effect that lets the baseline's
//! coefficients be smaller would gain by that alone.

use crate::design::errors_in_variables::ErrorsInVariables;
use crate::design::gram::{Columns, Gram};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A baseline column of which less than this share of its squares is its own is another's sum, to rounding: products carry
/// sixteen digits, and a good part of them is lost in a chain of a hundred eliminations. Derived from 16 digits: six are left for
/// the hundred eliminations, and no column of a motion is so nearly another's sum.
const DEPENDENT_SHARE: f64 = 1.0e-10;

/// Normal equations of the blocks after the baseline, `[columns, columns]`, in prior deviations.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// `XᵀPX`: products of the columns, the baseline projected out of them.
    pub normal: DMatrix<f64>,
    /// `XᵀPy`: products with the target.
    pub right: DVector<f64>,
    /// `yᵀPy`: whitened squares that the baseline alone leaves.
    pub squares: f64,
    /// Prior means.
    pub centre: DVector<f64>,
    /// Columns of each block, counted without the baseline.
    pub blocks: Vec<Range<usize>>,
    /// True where the products of each block are a diagonal.
    pub in_own_axes: bool,
    /// Rows.
    pub rows: f64,
    /// Baseline columns that the data tell better than their priors do.
    pub baseline: usize,
    /// Half the logarithm of the determinant of their products.
    pub half_log_determinant: f64,
    /// Mean products, a row, of the noise that the columns carry, that of the baseline with it; none where they carry none.
    pub(super) carried: Option<DMatrix<f64>>,
    /// What columns and target have in common because both are formed of the same noise, at the stated noise.
    pub(super) common: Common,
}

/// Products with the target that noise alone makes.
#[derive(Clone, Debug)]
pub(super) struct Common {
    /// Of the columns.
    pub(super) right: DVector<f64>,
    /// What the target's squares lose for each share of it, and for its square: the baseline's columns have such products as well.
    pub(super) squares: [f64; 2],
}

impl Reduced {
    /// Of the blocks that are asked for, by their numbers among those of the columns; the baseline is block 0. Cost: the square of the
    /// columns for each of the baseline's.
    pub fn new(
        gram: &Gram,
        errors_in_variables: &ErrorsInVariables,
        columns: &Columns,
        blocks: &[usize],
    ) -> Self {
        let base = columns.blocks[0].columns.clone();
        let asked = |b: &usize| columns.blocks[*b].columns.clone();
        let list: Vec<usize> = base
            .clone()
            .chain(blocks.iter().flat_map(asked))
            .chain([gram.width()])
            .collect();
        let training = gram.training(None);
        let mut whole = training.square(&list);
        let mut carried = errors_in_variables.products().block(&list, &list);
        let last = list.len() - 1;
        let rows = gram.total_rows() as f64;
        // What columns and target have in common because both are formed of the same noise explains nothing: amounts that nearly
        // cancel could rebuild the residual's own noise of it. Their true products stay (Fuller 1987's correction, of the products with
        // the target alone, so that the matrix stays positive). It is carried along as a target of its own.
        let common = last + 1;
        whole = whole.resize(common + 1, common + 1, 0.0);
        carried = carried.resize(common + 1, common + 1, 0.0);
        for c in 0..last {
            let product = rows * carried[(c, last)];
            (whole[(c, common)], whole[(common, c)]) = (product, product);
        }
        let (baseline, half_log_determinant) =
            eliminate(&mut whole, &mut carried, base.len(), TOLD);
        let (first, width) = (base.len(), list.len() - 1 - base.len());
        let right = |target| {
            whole
                .view((first, target), (width, 1))
                .column(0)
                .into_owned()
        };
        let by_stated_noise = Self {
            blocks: ranges(blocks.iter().map(|b| columns.blocks[*b].columns.len())),
            in_own_axes: false,
            normal: whole.view((first, first), (width, width)).into_owned(),
            right: right(last),
            squares: whole[(last, last)],
            centre: DVector::from_iterator(
                width,
                list[first..last].iter().map(|c| gram.centre[*c]),
            ),
            rows,
            baseline,
            half_log_determinant,
            carried: Some(carried.view((first, first), (width, width)).into_owned()),
            common: Common {
                right: right(common),
                squares: [2.0 * whole[(last, common)], -whole[(common, common)]],
            },
        };
        by_stated_noise.less_common(1.0)
    }

    /// The same columns, that carry no noise and are of no mean, with another target: its products with the columns, and its squares.
    #[cfg(test)]
    pub(super) fn with_target(&self, right: DVector<f64>, squares: f64) -> Self {
        let none = DVector::zeros(right.len());
        Self {
            common: Common {
                right: none.clone(),
                squares: [0.0; 2],
            },
            centre: none,
            carried: None,
            right,
            squares,
            ..self.clone()
        }
    }

    /// Products with the target, and those among them that noise makes.
    pub fn targets(&self) -> [&DVector<f64>; 2] {
        [&self.right, &self.common.right]
    }

    /// The same by noise whose variance is so many times the one that it was formed by: the columns carry as much more of it.
    pub fn at_noise(&self, times: f64) -> Self {
        let mut out = self.less_common(times - 1.0);
        out.carried = out.carried.map(|carried| carried * times);
        out
    }

    /// Takes a share of what noise makes common off the products with the target.
    fn less_common(&self, share: f64) -> Self {
        let Common {
            right,
            squares: [once, twice],
        } = &self.common;
        Self {
            right: &self.right - right * share,
            squares: self.squares - share * once - share * share * twice,
            common: Common {
                right: right.clone(),
                squares: [once + 2.0 * share * twice, *twice],
            },
            ..self.clone()
        }
    }

    /// Columns of a set of blocks.
    pub fn columns(&self, set: &[usize]) -> Vec<usize> {
        set.iter().flat_map(|b| self.blocks[*b].clone()).collect()
    }

    /// Whitened squares that coefficients of some columns add to the noise, over all rows, since the columns are formed of noisy
    /// readings.
    pub fn allowance(&self, list: &[usize], coefficients: &DVector<f64>) -> f64 {
        let Some(carried) = &self.carried else {
            return 0.0;
        };
        let noise = DMatrix::from_fn(list.len(), list.len(), |a, b| carried[(list[a], list[b])]);
        self.rows * coefficients.dot(&(noise * coefficients))
    }

    /// Logarithm of the density that coefficients of some columns seem to gain by rebuilding the target's own noise of the noise that the
    /// columns carry, at so many times the variance that the columns were formed by, where the target's is `noise`: at most 0. The density of
    /// the readings is that of the residuals times how far the residuals move with the readings, and what rebuilds the noise moves them less.
    /// Of a row's variance `1 − 2 cᵀw + wᵀCw` of the noise is left, with the products `c` of the columns' noise with the target's and `C`
    /// among each other; a row's density is made so much wider (Fuller 1987, measurement error models: the likelihood of the readings).
    pub fn log_rebuilt(
        &self,
        list: &[usize],
        coefficients: &DVector<f64>,
        times: f64,
        noise: f64,
    ) -> f64 {
        let each = list.iter().zip(coefficients.iter());
        let common: f64 = each.map(|(c, w)| self.common.right[*c] * w).sum();
        let added = self.allowance(list, coefficients) - 2.0 * times * common;
        let left = 1.0 + added / (self.rows * noise);
        0.5 * self.rows * left.clamp(f64::MIN_POSITIVE, 1.0).ln()
    }

    /// Products of some columns among each other.
    pub fn square(&self, list: &[usize]) -> DMatrix<f64> {
        self.across(list, list)
    }

    /// Products of some columns with others.
    pub fn across(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(rows.len(), columns.len());
        let runs: Vec<&[usize]> = rows.chunk_by(|a, b| a + 1 == *b).collect();
        for (column, mut to) in columns.iter().zip(out.column_iter_mut()) {
            let from = self.normal.column(*column);
            let mut at = 0;
            for run in &runs {
                to.rows_mut(at, run.len())
                    .copy_from(&from.rows(run[0], run.len()));
                at += run.len();
            }
        }
        out
    }

    /// Products of some columns with the target, and its squares, both less what the prior means explain.
    pub fn about_the_means(&self, list: &[usize]) -> (DVector<f64>, f64) {
        let mut right = DVector::from_fn(list.len(), |a, _| self.right[list[a]]);
        let mut squares = self.squares;
        for c in list.iter().filter(|c| self.centre[**c] != 0.0) {
            let (mean, column) = (self.centre[*c], self.normal.column(*c));
            squares -= 2.0 * mean * self.right[*c];
            for (a, right) in list.iter().zip(right.iter_mut()) {
                *right -= mean * column[*a];
                squares += mean * column[*a] * self.centre[*a];
            }
        }
        (right, squares)
    }
}

/// Places of blocks of these lengths, one after the other.
pub(super) fn ranges(lengths: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut end = 0;
    let next = |length| {
        let start = end;
        end += length;
        start..end
    };
    lengths.map(next).collect()
}

/// Whitened squares of a prior deviation below which the prior tells a baseline's column better than the data: it stays at its
/// mean. Derived from Bayes' rule: the data's weight is these squares, the prior's is one.
const TOLD: f64 = 1.0;

/// Eliminates the first columns one after the other from the products, those with fewer squares of their own than asked aside, and applies
/// the same combinations of columns to the carried noise. Number of columns eliminated, and half the logarithm of the determinant of their
/// products.
fn eliminate(
    whole: &mut DMatrix<f64>,
    carried: &mut DMatrix<f64>,
    first: usize,
    least: f64,
) -> (usize, f64) {
    let own: Vec<f64> = (0..first).map(|k| whole[(k, k)]).collect();
    let (mut count, mut half_log_determinant) = (0, 0.0);
    for k in 0..first {
        let pivot = whole[(k, k)];
        if pivot <= (DEPENDENT_SHARE * own[k]).max(least) {
            continue;
        }
        count += 1;
        half_log_determinant += 0.5 * pivot.ln();
        let mut share = whole.column(k) / pivot;
        (0..=k).for_each(|a| share[a] = 0.0);
        let products = share.clone() * pivot;
        whole.ger(-1.0, &products, &share, 1.0);
        combine(carried, k, &share);
    }
    (count, half_log_determinant)
}

/// Takes a share of one column off each other one, in a matrix of their products.
fn combine(products: &mut DMatrix<f64>, which: usize, share: &DVector<f64>) {
    let own = products.column(which).into_owned();
    products.ger(-1.0, share, &own, 1.0);
    let rest = &own - share * own[which];
    for (mut column, by) in products.column_iter_mut().zip(share.iter()) {
        column.axpy(-by, &rest, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use nalgebra::{DMatrix, DVector};

    const ROWS: usize = 500;
    const VARIANCE: f64 = 0.01;
    const SHARE: f64 = 0.5;

    /// A column that carries the target's own noise, as much of it, rebuilds a part `b` of it by that amount: of each row's noise `1 − b` is
    /// left, and the density of a row is as much narrower.
    #[test]
    fn what_rebuilds_the_noise_gains_nothing_by_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let row = |_| vec![1.0, normal(&mut rng), normal(&mut rng)];
        let rows: Vec<Vec<f64>> = (0..ROWS).map(row).collect();
        let problem = SyntheticProblem::of_rows(1, &[("block", 1)], &rows);
        let reduced = problem.with_shared_errors(1.0, 1.0).reduced(&[1]);
        let rebuilt = |amount: f64, times: f64| {
            let amounts = DVector::from_element(1, amount);
            reduced
                .at_noise(times)
                .log_rebuilt(&[0], &amounts, times, times)
        };
        for part in [0.1_f64, 0.5, 0.9] {
            let lost = ROWS as f64 * (1.0 - part).ln();
            assert!((rebuilt(part, 1.0) / lost - 1.0).abs() < 0.02, "{part}");
            assert!((rebuilt(part, 9.0) / lost - 1.0).abs() < 0.02, "{part}");
        }
        // What adds to the noise gains nothing either.
        assert_eq!(rebuilt(-0.5, 1.0), 0.0);
    }

    /// At four times the noise, products with the target are those that are left when four times what noise makes common is taken off, the
    /// baseline's included: by whole matrices.
    #[test]
    fn louder_noise_makes_more_common() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let row = |_| {
            let (one, other) = (normal(&mut rng), normal(&mut rng));
            let target = one - 2.0 * other + normal(&mut rng);
            vec![1.0, one, 0.3 * one + other, target]
        };
        let rows: Vec<Vec<f64>> = (0..ROWS).map(row).collect();
        let problem = SyntheticProblem::of_rows(2, &[("block", 1)], &rows);
        let stated = problem.with_shared_errors(VARIANCE, SHARE).reduced(&[1]);
        let part = |columns: std::ops::Range<usize>| {
            DMatrix::from_fn(ROWS, columns.len(), |r, c| rows[r][columns.start + c])
        };
        let (baseline, block, target) = (part(0..2), part(2..3), part(3..4));
        let inverse = (baseline.transpose() * &baseline).try_inverse().unwrap();
        let amounts = DVector::from_element(1, 1.0);
        for times in [1.0, 4.0] {
            let common = times * ROWS as f64 * SHARE * VARIANCE;
            let mut of_baseline = baseline.transpose() * &target;
            of_baseline[1] -= common;
            let across = block.transpose() * &baseline;
            let right =
                (block.transpose() * &target)[0] - common - (across * &inverse * &of_baseline)[0];
            let squares =
                target.norm_squared() - (of_baseline.transpose() * &inverse * &of_baseline)[0];
            let found = stated.at_noise(times);
            assert!((found.right[0] - right).abs() < 1e-8, "{found:?} {right}");
            assert!(
                (found.squares - squares).abs() < 1e-8,
                "{found:?} {squares}"
            );
            let ratio = found.allowance(&[0], &amounts) / stated.allowance(&[0], &amounts);
            assert!((ratio - times).abs() < 1e-9, "{ratio}");
        }
    }
}
