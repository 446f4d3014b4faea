//! For tests: columns and a target of which everything is known.

use crate::data::folds::FOLDS;
use crate::design::errors_in_variables::ErrorsInVariables;
use crate::design::gram::{Columns, Gram};
use crate::inference::cross_validation::CrossValidation;
use crate::posterior::reduced::Reduced;
use effects::random::{ChaCha8Rng, SeedableRng};
use effects::sensor::Regressor;
use normal_equations::symmetric::Symmetric;

/// Rows a fold.
const ROWS: usize = 400;

/// Columns and their products.
pub struct SyntheticProblem {
    columns: Columns,
    gram: Gram,
    errors_in_variables: ErrorsInVariables,
}

impl SyntheticProblem {
    /// A constant as the baseline, then blocks with the prior sizes of their columns. `row` draws a row: a one, the columns, the
    /// target.
    pub fn new(blocks: &[(&str, &[f64])], row: &dyn Fn(&mut ChaCha8Rng) -> Vec<f64>) -> Self {
        let mut columns = Columns::default();
        let column = |name: &str, size: f64| Regressor::channel(name, "m", size, 0, |_| 1.0);
        columns.push("baseline", vec![column("constant", 1.0)]);
        for (name, sizes) in blocks {
            columns.push(
                *name,
                sizes.iter().map(|size| column(name, *size)).collect(),
            );
        }
        let width = columns.regressors.len();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let fold: Vec<Symmetric> = (0..FOLDS).map(|_| products(width, row, &mut rng)).collect();
        Self::of(columns, fold, vec![ROWS; FOLDS])
    }

    fn of(columns: Columns, fold: Vec<Symmetric>, rows: Vec<usize>) -> Self {
        let width = columns.regressors.len();
        let mut total = Symmetric::zeros(width + 1);
        fold.iter().for_each(|fold| total += fold);
        let gram = Gram {
            total,
            fold,
            rows,
            scale: vec![1.0; width],
            centre: vec![0.0; width],
            shrunk: vec![1.0; width],
            overstated: false,
            loud: false,
        };
        let errors_in_variables = ErrorsInVariables::none(width);
        Self {
            columns,
            gram,
            errors_in_variables,
        }
    }

    /// Rows that are known: baseline columns, then blocks, then the target. Prior deviations are one.
    pub fn of_rows(baseline: usize, blocks: &[(&str, usize)], rows: &[Vec<f64>]) -> Self {
        let mut columns = Columns::default();
        let column = |name: &str| Regressor::channel(name, "m", 1.0, 0, |_| 1.0);
        let of = |name: &str, count: usize| (0..count).map(|_| column(name)).collect();
        columns.push("baseline", of("baseline", baseline));
        for (name, count) in blocks {
            columns.push(*name, of(name, *count));
        }
        let width = columns.regressors.len();
        let mut fold = vec![Symmetric::zeros(width + 1); FOLDS];
        let mut counts = vec![0; FOLDS];
        for (k, row) in rows.iter().enumerate() {
            add(row, &mut fold[k % FOLDS]);
            counts[k % FOLDS] += 1;
        }
        Self::of(columns, fold, counts)
    }

    /// Prior means of the columns, the baseline's first.
    pub fn about(mut self, centre: &[f64]) -> Self {
        self.gram.centre = centre.to_vec();
        self
    }

    /// Normal equations of some blocks without the baseline.
    pub fn reduced(&self, blocks: &[usize]) -> Reduced {
        Reduced::new(&self.gram, &self.errors_in_variables, &self.columns, blocks)
    }

    /// The same, each column of the blocks carrying noise of this variance.
    pub fn with_errors_in_variables(mut self, variance: f64) -> Self {
        self.errors_in_variables =
            ErrorsInVariables::alike(self.columns.regressors.len(), variance);
        self
    }

    /// The same, of which the target has a share as well.
    pub fn with_shared_errors(mut self, variance: f64, share: f64) -> Self {
        self.errors_in_variables =
            ErrorsInVariables::shared(self.columns.regressors.len(), variance, share);
        self
    }

    /// For the comparison of sets of blocks.
    pub fn cross_validation(&self) -> CrossValidation<'_> {
        CrossValidation::new(&self.gram, &self.columns, &self.errors_in_variables)
    }
}

fn products(
    width: usize,
    row: &dyn Fn(&mut ChaCha8Rng) -> Vec<f64>,
    rng: &mut ChaCha8Rng,
) -> Symmetric {
    let mut sum = Symmetric::zeros(width + 1);
    for _ in 0..ROWS {
        add(&row(rng), &mut sum);
    }
    sum
}

fn add(row: &[f64], sum: &mut Symmetric) {
    for (column, value) in row.iter().enumerate() {
        let below = sum.below_mut(column).iter_mut().zip(&row[column..]);
        below.for_each(|(sum, other)| *sum += value * other);
    }
}
