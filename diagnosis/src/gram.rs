//! One pass over the samples: products of all columns, by fold, so that every later comparison is small algebra.

use crate::products::{Upright, mirror};
use crate::scene::Scene;
use effects::sensor::{CHANNELS, Regressor};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Folds of the cross-validation.
pub const FOLDS: usize = 5;
/// Samples that are turned into rows at once.
const CHUNK: usize = 128;
/// Sums that are formed side by side. Their number and what goes into each is the same on every machine and in every run, so
/// that the last digit is.
const LANES: usize = 4;

/// What a group of columns stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Name: an effect's, or a coordinate's.
    pub name: String,
    /// Its columns.
    pub columns: Range<usize>,
}

/// All columns of a comparison.
#[derive(Default)]
pub struct Columns {
    /// One regressor a column.
    pub regressors: Vec<Regressor>,
    /// Groups, in order; the first is the baseline.
    pub blocks: Vec<Block>,
    /// Prior mean of each amount.
    pub centre: Vec<f64>,
    /// True where the amount is known to be that and not fitted.
    pub held: Vec<bool>,
}

impl Columns {
    /// Appends a group and returns its number.
    pub fn push(&mut self, name: impl Into<String>, regressors: Vec<Regressor>) -> usize {
        let start = self.regressors.len();
        self.centre
            .extend(std::iter::repeat_n(0.0, regressors.len()));
        self.held
            .extend(std::iter::repeat_n(false, regressors.len()));
        self.regressors.extend(regressors);
        self.blocks.push(Block {
            name: name.into(),
            columns: start..self.regressors.len(),
        });
        self.blocks.len() - 1
    }
}

/// Products of whitened columns by fold; the last column is the target, minus the residual.
pub struct Gram {
    /// `[fold]`, each `[columns + 1, columns + 1]`, of columns scaled by their prior deviation.
    pub fold: Vec<DMatrix<f64>>,
    /// Their sum.
    pub(crate) total: DMatrix<f64>,
    /// Rows in each fold.
    pub rows: [usize; FOLDS],
    /// Prior deviation of each amount: a column times this is one prior deviation of effect.
    pub scale: Vec<f64>,
    /// Prior mean, in prior deviations.
    pub centre: Vec<f64>,
    /// Prior deviation over the physical one.
    pub shrunk: Vec<f64>,
    /// True if the readings show less noise than is stated: less than the stated noise may be left.
    pub overstated: bool,
}

/// Fold of each sample: pieces of runs, never single samples; a place that is passed twice falls into different folds.
pub fn folds(stretch: &[usize]) -> Vec<u8> {
    let mut out = vec![0; stretch.len()];
    let mut start = 0;
    while start < stretch.len() {
        let end = (start..stretch.len())
            .find(|&i| stretch[i] != stretch[start])
            .unwrap_or(stretch.len());
        let length = end - start;
        let pieces = (length / 20).clamp(1, 4 * FOLDS);
        for (k, fold) in out[start..end].iter_mut().enumerate() {
            // Stepping by two folds from run to run parts there from back.
            *fold = ((k * pieces / length + 2 * stretch[start]) % FOLDS) as u8;
        }
        start = end;
    }
    out
}

/// Sums of a channel's squares and values, and how many there were.
type Spread = [(f64, f64, usize); CHANNELS];

/// Spread of each column's response over the rows where it acts, m: of g_p where it acts there, else of the largest channel.
fn sizes(scene: &Scene, columns: &Columns) -> Vec<f64> {
    let step = (scene.len() / 3000).max(1);
    let list: Vec<usize> = (0..scene.len()).step_by(step).collect();
    let parts = list.par_chunks(list.len().div_ceil(LANES).max(1));
    let parts: Vec<Vec<Spread>> = parts.map(|part| spreads(scene, columns, part)).collect();
    let total = |c: usize| {
        let mut sum = Spread::default();
        for (channel, sum) in sum.iter_mut().enumerate() {
            for (square, value, count) in parts.iter().map(|p| p[c][channel]) {
                *sum = (sum.0 + square, sum.1 + value, sum.2 + count);
            }
        }
        sum
    };
    (0..columns.regressors.len())
        .map(|c| size(&total(c)))
        .collect()
}

fn spreads(scene: &Scene, columns: &Columns, samples: &[usize]) -> Vec<Spread> {
    let mut sums = vec![Spread::default(); columns.regressors.len()];
    for &i in samples {
        let rows = scene.rows(i);
        let moment = scene.moment(i);
        for (sum, regressor) in sums.iter_mut().zip(&columns.regressors) {
            let response = rows.response(regressor, &moment);
            for (a, channel) in response.iter().zip(rows.channel).take(rows.count) {
                if *a != 0.0 {
                    sum[channel].0 += a * a;
                    sum[channel].1 += a;
                    sum[channel].2 += 1;
                }
            }
        }
    }
    sums
}

fn size(sum: &Spread) -> f64 {
    // About the mean: what is constant is an offset's business, unless there is nothing else.
    let spread = |(square, sum, count): (f64, f64, usize)| {
        let n = count as f64;
        let (square, mean) = (square / n, sum / n);
        let variance = square - mean * mean;
        if count < 3 {
            0.0
        } else if variance > 1e-6 * square {
            variance.sqrt()
        } else {
            square.sqrt()
        }
    };
    let all = sum.map(spread);
    if all[0] > 0.0 {
        all[0]
    } else {
        all.iter().copied().fold(0.0, f64::max)
    }
}

impl Gram {
    /// Accumulates over all kept samples. Cost: rows times columns squared.
    pub fn new(scene: &Scene, columns: &Columns, folds: &[u8]) -> Self {
        let size = sizes(scene, columns);
        let scale: Vec<f64> = columns
            .regressors
            .iter()
            .zip(&size)
            .map(|(r, s)| match r.deviation {
                _ if *s <= 0.0 => 0.0,
                Some(deviation) => deviation,
                None => r.size_m / s,
            })
            .collect();
        let centre = columns
            .centre
            .iter()
            .zip(&scale)
            .map(|(c, s)| if *s > 0.0 { c / s } else { 0.0 })
            .collect();
        let mut fold = Vec::with_capacity(FOLDS);
        let mut rows = [0; FOLDS];
        for (f, count) in rows.iter_mut().enumerate() {
            let list: Vec<usize> = (0..scene.len())
                .filter(|&i| scene.keep[i] && usize::from(folds[i]) == f)
                .collect();
            let (sum, found) = products(scene, columns, &scale, &list);
            fold.push(sum);
            *count = found;
        }
        fold.iter_mut().for_each(mirror);
        let mut total = DMatrix::zeros(scale.len() + 1, scale.len() + 1);
        fold.iter().for_each(|f| total += f);
        Self {
            fold,
            total,
            rows,
            shrunk: vec![1.0; scale.len()],
            scale,
            centre,
            overstated: scene.observations.overstated,
        }
    }

    /// Takes prior deviations to be so many times what they were; prior means stay what they are in their units.
    pub fn rescale(&mut self, factor: &[f64]) {
        for (c, by) in factor.iter().enumerate() {
            self.scale[c] *= by;
            self.shrunk[c] *= by;
            self.centre[c] /= by;
            for sum in self.fold.iter_mut().chain([&mut self.total]) {
                sum.row_mut(c).scale_mut(*by);
                sum.column_mut(c).scale_mut(*by);
            }
        }
    }

    /// Number of columns without the target.
    pub fn width(&self) -> usize {
        self.scale.len()
    }

    /// Number of rows.
    pub fn total_rows(&self) -> usize {
        self.rows.iter().sum()
    }

    /// Sum over all folds but one (or all).
    pub fn training(&self, without: Option<usize>) -> DMatrix<f64> {
        match without {
            Some(f) => &self.total - &self.fold[f],
            None => self.total.clone(),
        }
    }

    /// The same as it is asked for, without memory of its own.
    pub fn trained_without(&self, fold: usize) -> Training<'_> {
        Training {
            total: &self.total,
            test: &self.fold[fold],
        }
    }
}

/// Sum over all folds but one.
#[derive(Clone, Copy)]
pub struct Training<'a> {
    total: &'a DMatrix<f64>,
    /// The fold that is left out.
    pub test: &'a DMatrix<f64>,
}

impl Training<'_> {
    /// An element.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.total[(row, column)] - self.test[(row, column)]
    }

    /// Number of the target's row and column.
    pub fn last(&self) -> usize {
        self.total.nrows() - 1
    }

    /// Some rows and columns.
    pub fn block(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), columns.len(), |a, b| {
            self.at(rows[a], columns[b])
        })
    }
}

/// Products over some samples, and their rows, by lanes side by side.
fn products(
    scene: &Scene,
    columns: &Columns,
    scale: &[f64],
    samples: &[usize],
) -> (DMatrix<f64>, usize) {
    let width = scale.len() + 1;
    let work = |lane: usize| {
        let mut sum = DMatrix::zeros(width, width);
        let mut upright = Upright::new(width);
        let chunks = samples.chunks(CHUNK).skip(lane).step_by(LANES);
        let rows =
            chunks.map(|chunk| accumulate(scene, columns, scale, chunk, &mut upright, &mut sum));
        let rows: usize = rows.sum();
        (sum, rows)
    };
    let work = &work;
    let parts: Vec<_> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..LANES)
            .map(|lane| scope.spawn(move || work(lane)))
            .collect();
        handles.into_iter().filter_map(|h| h.join().ok()).collect()
    });
    let mut parts = parts.into_iter();
    let first = parts
        .next()
        .unwrap_or_else(|| (DMatrix::zeros(width, width), 0));
    parts.fold(first, |mut all, part| {
        all.0 += part.0;
        all.1 += part.1;
        all
    })
}

/// Adds a chunk's products to the lower triangle. Columns that are zero throughout the chunk (shapes of another run, of
/// another time, of another place) cost nothing but their evaluation.
fn accumulate(
    scene: &Scene,
    columns: &Columns,
    scale: &[f64],
    samples: &[usize],
    upright: &mut Upright,
    gram: &mut DMatrix<f64>,
) -> usize {
    upright.clear();
    let last = scale.len();
    for &i in samples {
        let rows = scene.rows(i);
        if rows.count == 0 {
            continue;
        }
        let moment = scene.moment(i);
        let by_reading = rows.white_by_reading();
        upright.extend(rows.count);
        for (c, regressor) in columns.regressors.iter().enumerate() {
            if let Some(white) = rows.white_response(&by_reading, regressor, &moment) {
                upright.set(c, &white[..rows.count], scale[c]);
            }
        }
        let white = rows.whitened(&rows.residual_m);
        upright.set(last, &white[..rows.count], -1.0);
    }
    upright.add_products(gram);
    upright.rows()
}

/// Fit of some columns with their priors, on a training Gram.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Columns in the model.
    pub columns: Vec<usize>,
    /// Amounts in prior deviations.
    pub amount: DVector<f64>,
    /// Logarithm of the marginal likelihood for unit noise, up to a constant of the data.
    pub log_evidence: f64,
}

/// Solves for the columns with unit normal priors about `centre`, noise variance `variance`.
pub fn solve(
    training: &DMatrix<f64>,
    columns: &[usize],
    centre: &[f64],
    variance: f64,
) -> Option<Fit> {
    let n = columns.len();
    let last = training.nrows() - 1;
    let precision = 1.0 / variance;
    let mut normal = DMatrix::from_fn(n, n, |a, b| training[(columns[a], columns[b])] * precision);
    let mut right = DVector::from_fn(n, |a, _| training[(columns[a], last)] * precision);
    for a in 0..n {
        normal[(a, a)] += 1.0;
        right[a] += centre[columns[a]];
    }
    let factor = normal.cholesky()?;
    let amount = factor.solve(&right);
    let log_det: f64 = factor
        .l_dirty()
        .diagonal()
        .iter()
        .map(|d| d.ln())
        .sum::<f64>();
    let prior: f64 = columns.iter().map(|&c| centre[c] * centre[c]).sum();
    let log_evidence =
        0.5 * (right.dot(&amount) - prior - training[(last, last)] * precision) - log_det;
    Some(Fit {
        columns: columns.to_vec(),
        amount,
        log_evidence,
    })
}

/// Squared whitened residual of a fit on other data.
pub fn squares(test: &DMatrix<f64>, fit: &Fit) -> f64 {
    let last = test.nrows() - 1;
    let n = fit.columns.len();
    let mut sum = test[(last, last)];
    for a in 0..n {
        let ca = fit.columns[a];
        let mut inner = -2.0 * test[(ca, last)];
        for b in 0..n {
            inner += test[(ca, fit.columns[b])] * fit.amount[b];
        }
        sum += inner * fit.amount[a];
    }
    sum
}
