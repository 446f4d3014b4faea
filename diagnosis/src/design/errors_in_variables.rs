//! Noise that readings carry into the columns. A shape is evaluated at a noisy place, so that a set of large amounts which
//! nearly cancel can rebuild the residual's own noise and leave less than the noise, held out as well (the trivial answer of a
//! constraint fit). What such a set leaves is told apart by the noise that it would leave: errors in variables, as in Fuller
//! 1987's corrected score.

use crate::design::gram::Columns;
use crate::linearization::recording::{LatentDisplacement, LinearizedRecording, ROWS};
use effects::over::Extent;
use effects::sensor::Covariates;
use normal_equations::products::RowBuffer;
use normal_equations::symmetric::Symmetric;
use rayon::prelude::*;

/// Samples that the mean is taken over.
const PRODUCT_SAMPLES: usize = 500;
/// Samples that are turned into rows at once.
const CHUNK_SAMPLES: usize = 32;
/// Sums that are formed side by side: as many on every machine.
const LANES: usize = 2;
/// A fit that takes noise away is believed only for what it takes beyond that much again: the allowance is of first order.
const DOUBT: f64 = 2.0;
/// Step of the derivatives by a reading, m.
const STEP_M: f64 = 1.0e-8;

/// Mean products, a row, of the columns' and the target's derivatives by the readings, each times that reading's noise.
#[derive(Clone, Debug)]
pub struct ErrorsInVariables(Symmetric);

impl ErrorsInVariables {
    /// Cost: a twentieth to a half of the products themselves. The coordination sensor's noise is left aside: its shapes are
    /// smooth over many times that noise.
    pub fn new(linearized: &LinearizedRecording, columns: &Columns, scale: &[f64]) -> Self {
        let width = scale.len() + 1;
        let in_use: Vec<usize> = (0..linearized.len())
            .filter(|&i| linearized.mask[i])
            .collect();
        let step = (in_use.len() / PRODUCT_SAMPLES).max(1);
        let list: Vec<usize> = in_use.into_iter().step_by(step).collect();
        let stepped = std::array::from_fn(|s| stepped(linearized, s));
        let parts: Vec<(Symmetric, usize)> = list
            .par_chunks(list.len().div_ceil(LANES).max(1))
            .map(|samples| products_of(linearized, &stepped, columns, scale, samples))
            .collect();
        let mut sum = Symmetric::zeros(width);
        let mut count = 0;
        for (part, rows) in parts {
            sum += &part;
            count += rows;
        }
        sum.divide(count.max(1) as f64);
        Self(sum)
    }

    /// None: columns that are known without noise.
    #[cfg(test)]
    pub fn none(width: usize) -> Self {
        Self(Symmetric::zeros(width + 1))
    }

    /// The same variance in each column but the first, and none in the target.
    #[cfg(test)]
    pub fn alike(width: usize, variance: f64) -> Self {
        let mut products = Symmetric::zeros(width + 1);
        (1..width).for_each(|c| products.below_mut(c)[0] = variance);
        Self(products)
    }

    /// The mean products; the target's derivatives are in the last row and column.
    pub fn products(&self) -> &Symmetric {
        &self.0
    }

    /// Squares, a row, that a fit's own are counted too high by, of its squares over [`Self::products`]: the noise that it adds,
    /// or below zero what it takes away, which counts twice.
    pub fn allowance(&self, squares: f64) -> f64 {
        let last = self.0.order() - 1;
        let added = squares - self.0[(last, last)];
        if added < 0.0 { DOUBT * added } else { added }
    }
}

/// The linearized recording with one segment's raw readings a step further. Where the segment's place is that of its neighbours, the place
/// stays.
fn stepped<'a>(linearized: &LinearizedRecording<'a>, segment: usize) -> LinearizedRecording<'a> {
    let mut displacement: LatentDisplacement = linearized.displacement.clone();
    let off = &mut displacement.electronic_m[segment];
    off.resize(linearized.len(), 0.0);
    off.iter_mut().for_each(|off| *off += STEP_M);
    let mut out = linearized.moved(linearized.baseline.clone(), displacement);
    out.displacement.total_m[segment].resize(linearized.len(), 0.0);
    for i in 0..out.calibrated_m[segment].len() {
        out.displacement.total_m[segment][i] += if linearized.is_quiet(segment, i) {
            linearized.calibrated_m[segment][i] - out.calibrated_m[segment][i]
        } else {
            STEP_M
        };
    }
    out
}

fn products_of(
    linearized: &LinearizedRecording,
    stepped: &[LinearizedRecording; 4],
    columns: &Columns,
    scale: &[f64],
    samples: &[usize],
) -> (Symmetric, usize) {
    let width = scale.len() + 1;
    let mut upright = RowBuffer::new(width, CHUNK_SAMPLES * ROWS * 4);
    let mut sum = Symmetric::zeros(width);
    let mut count = 0;
    for chunk in samples.chunks(CHUNK_SAMPLES) {
        upright.clear();
        for &i in chunk {
            count += add_rows(linearized, stepped, columns, scale, i, &mut upright);
        }
        upright.add_products(&mut sum);
    }
    (sum, count)
}

/// Adds the changes of a sample's rows with each segment's reading; the sample's number of rows.
fn add_rows(
    linearized: &LinearizedRecording,
    stepped: &[LinearizedRecording; 4],
    columns: &Columns,
    scale: &[f64],
    i: usize,
    upright: &mut RowBuffer,
) -> usize {
    let rows = linearized.rows(i);
    let by_reading = rows.white_by_reading();
    let variance = linearized.reading_variance(i);
    let here = linearized.covariates(i);
    let segments: Vec<usize> = (0..4).filter(|s| linearized.scope.segments[*s]).collect();
    let there: Vec<Covariates> = segments.iter().map(|s| stepped[*s].covariates(i)).collect();
    let extent = Extent::of(there.iter().chain([&here]));
    let acting: Vec<usize> = (0..scale.len())
        .filter(|c| columns.regressors[*c].may_act(&extent))
        .collect();
    let response = |c: usize, covariates: &Covariates| {
        rows.white_response(&by_reading, &columns.regressors[c], covariates)
    };
    let before: Vec<Option<[f64; ROWS]>> = acting.iter().map(|c| response(*c, &here)).collect();
    for (&s, there) in segments.iter().zip(&there) {
        let noise = linearized.noise[s] * linearized.observations.position_noise_m[s][i] / STEP_M;
        upright.extend(rows.count);
        for (&c, before) in acting.iter().zip(&before) {
            let after = response(c, there);
            if after != *before {
                let (a, b) = (before.unwrap_or_default(), after.unwrap_or_default());
                let change: [f64; ROWS] = std::array::from_fn(|row| b[row] - a[row]);
                upright.set(c, &change[..rows.count], noise * scale[c]);
            }
        }
        let target = std::array::from_fn(|row| -rows.by_reading[row][s] * variance[s].sqrt());
        let target = rows.whitened(&target);
        upright.set(scale.len(), &target[..rows.count], 1.0);
    }
    rows.count
}
