//! Noise that readings carry into the columns. A shape is evaluated at a noisy place, so that a set of large amounts which
//! nearly cancel can rebuild the residual's own noise and leave less than the noise, held out as well (the trivial answer of a
//! constraint fit). What such a set leaves is told apart by the noise that it would leave: errors in variables, as in Fuller
//! 1987's corrected score.

use crate::design::column_values::{by_source, in_order_of_sources, places, product};
use crate::design::gram::Columns;
use crate::linearization::recording::{LinearizedRecording, ROWS, SOURCES, SampleRows, TARGET};
use effects::over::Extent;
use effects::sensor::Covariates;
use normal_equations::by_source::SourceBuffer;
use normal_equations::symmetric::Symmetric;
use rayon::prelude::*;

/// Samples that the mean is taken over. Derived from their scatter: a mean product of 500 is known to 4 %.
const PRODUCT_SAMPLES: usize = 500;
/// Samples that are turned into rows at once. Cost alone: the rows of a chunk stay in the processor's cache.
const CHUNK_SAMPLES: usize = 64;
/// Sums that are formed side by side: as many on every machine. Cost alone: their number is fixed so that the last digit is.
const LANES: usize = 2;
/// A fit that takes noise away is believed only for what it takes beyond that much again: the allowance is of first order.
/// A prior: what a first order leaves out may be as much as it is.
const DOUBT: f64 = 2.0;
/// Step of the derivatives by a reading, m. Derived from 16 digits: of a place of some centimetres rounding makes 1e-9 of the
/// derivative, and the bend of order 16 makes 1e-3 at the most of its slope.
const STEP_M: f64 = 1.0e-8;

/// Mean products, a row, of the columns' and the target's derivatives by the readings, each times that reading's noise.
#[derive(Clone, Debug)]
pub struct ErrorsInVariables(Symmetric);

impl ErrorsInVariables {
    /// Of the segments' noise, and under a beacon of the coordination sensor's. That one's shapes are smooth over many times its noise, but a gain that
    /// the motion hardly tells takes noise away all the same. Cost: a twentieth to three quarters of the products themselves.
    pub fn new(linearized: &LinearizedRecording, columns: &Columns, scale: &[f64]) -> Self {
        let width = scale.len() + 1;
        let in_use: Vec<usize> = (0..linearized.len())
            .filter(|&i| linearized.mask[i])
            .collect();
        let step = (in_use.len() / PRODUCT_SAMPLES).max(1);
        let list: Vec<usize> = in_use.into_iter().step_by(step).collect();
        let in_order = in_order_of_sources(&columns.regressors);
        let parts: Vec<(Symmetric, usize)> = list
            .par_chunks(list.len().div_ceil(LANES).max(1))
            .map(|samples| products_of(linearized, columns, &in_order, scale, samples))
            .collect();
        let mut sum = Symmetric::zeros(width);
        let mut count = 0;
        for (part, rows) in parts {
            sum += &part;
            count += rows;
        }
        sum.divide(count.max(1) as f64);
        Self(sum.reordered(&places(&in_order)))
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

    /// The same, of which the target has a share as well.
    #[cfg(test)]
    pub fn shared(width: usize, variance: f64, share: f64) -> Self {
        let mut out = Self::alike(width, variance);
        (1..width).for_each(|c| out.0.below_mut(c)[width - c] = share * variance);
        out
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

/// What the sensor knows at a sample where an axis of the coordination sensor reads a step further. Where the neighbours tell the deflection, that
/// stays, and so does its rate, which many samples tell.
fn deflected(linearized: &LinearizedRecording, axis: usize, here: &Covariates) -> Covariates {
    let step = deflection_step(linearized);
    let mut out = here.clone();
    if out.steady_tan_psi[axis] == out.tan_psi[axis] {
        out.steady_tan_psi[axis] += step;
    }
    out.tan_psi[axis] += step;
    let full_scale = linearized.observations.tan_full_scale;
    if full_scale > 0.0 {
        out.deflection[axis] += step / full_scale;
    }
    out
}

/// A step of tan(psi) that the beacon's height makes [`STEP_M`].
fn deflection_step(linearized: &LinearizedRecording) -> f64 {
    STEP_M / linearized.baseline.height_m
}

fn products_of(
    linearized: &LinearizedRecording,
    columns: &Columns,
    in_order: &[usize],
    scale: &[f64],
    samples: &[usize],
) -> (Symmetric, usize) {
    let mut buffer = SourceBuffer::new(SOURCES);
    let mut sum = Symmetric::zeros(scale.len() + 1);
    let mut count = 0;
    for chunk in samples.chunks(CHUNK_SAMPLES) {
        let rows: Vec<SampleRows> = chunk.iter().map(|i| linearized.rows(*i)).collect();
        count += rows.iter().map(|rows| rows.count).sum::<usize>();
        let changes = Changes::new(linearized, chunk, &rows);
        changes.add_products(columns, in_order, scale, &mut buffer, &mut sum);
    }
    (sum, count)
}

/// Noise of a reading over the step by which it is changed, at a sample; not finite where it is not there.
fn noise_of_step(linearized: &LinearizedRecording, reading: usize, i: usize) -> f64 {
    let o = linearized.observations;
    let over_stated = linearized.noise[reading];
    match reading.checked_sub(4) {
        None => over_stated * o.position_noise_m[reading][i] / STEP_M,
        Some(axis) => over_stated * o.tan_psi_noise[axis][i] / deflection_step(linearized),
    }
}

/// What a step of each reading changes at some samples: reading by reading, sample by sample.
struct Changes {
    here: Vec<Covariates>,
    there: Vec<Vec<Covariates>>,
    /// Each source's vector, times the reading's noise over the step; the target's is that of its derivative.
    vectors: Vec<[[f64; ROWS]; SOURCES]>,
}

impl Changes {
    fn new(linearized: &LinearizedRecording, samples: &[usize], rows: &[SampleRows]) -> Self {
        let segments = (0..4).filter(|s| linearized.scope.segments[*s]);
        let axes = (0..2).filter(|_| linearized.scope.beacon);
        let readings: Vec<usize> = segments.chain(axes.map(|axis| 4 + axis)).collect();
        let here: Vec<Covariates> = samples.iter().map(|i| linearized.covariates(*i)).collect();
        let there = |reading: &usize| match reading.checked_sub(4) {
            None => samples
                .iter()
                .map(|i| linearized.covariates_at_step(*i, *reading, STEP_M))
                .collect(),
            Some(axis) => here
                .iter()
                .map(|m| deflected(linearized, axis, m))
                .collect(),
        };
        let sources: Vec<_> = rows.iter().map(SampleRows::white_sources).collect();
        let vectors = |reading: &usize| {
            let (reading, of_samples) = (*reading, samples.iter().zip(rows).zip(&sources));
            of_samples.map(move |((&i, rows), sources)| {
                let noise = noise_of_step(linearized, reading, i);
                let variance = linearized.reading_variance(i)[reading];
                // A reading that is not there has no noise, and its rows no part of it.
                if !noise.is_finite() {
                    return [[0.0; ROWS]; SOURCES];
                }
                let mut vectors = *sources;
                vectors.iter_mut().flatten().for_each(|v| *v *= noise);
                let by = rows.by_reading.map(|by| -by[reading] * variance.sqrt());
                vectors[TARGET] = rows.whitened(&by);
                vectors
            })
        };
        Self {
            there: readings.iter().map(there).collect(),
            vectors: readings.iter().flat_map(vectors).collect(),
            here,
        }
    }

    /// Adds the products of the columns' changes, reading by reading: most columns follow few of the readings, and a column that a reading does not
    /// change costs no product.
    fn add_products(
        &self,
        columns: &Columns,
        in_order: &[usize],
        scale: &[f64],
        buffer: &mut SourceBuffer,
        sum: &mut Symmetric,
    ) {
        let extent = Extent::of(self.there.iter().flatten().chain(&self.here));
        let in_use = in_order.iter().take(scale.len()).enumerate();
        let in_use = in_use.filter(|(_, c)| columns.regressors[**c].may_act(&extent));
        let here: Vec<&Covariates> = self.here.iter().collect();
        let before = in_use.map(|(place, &c)| (place, c, by_source(&columns.regressors[c], &here)));
        let before: Vec<_> = before.collect();
        for (there, vectors) in self.there.iter().zip(self.vectors.chunks(here.len())) {
            let there: Vec<&Covariates> = there.iter().collect();
            buffer.begin(there.len());
            for (place, c, before) in &before {
                let after = by_source(&columns.regressors[*c], &there);
                for ((source, before), (_, after)) in before.iter().zip(after) {
                    let change = after.iter().zip(before).map(|(b, a)| (b - a) * scale[*c]);
                    buffer.push(*source, *place, change);
                }
            }
            buffer.push(TARGET, scale.len(), there.iter().map(|_| 1.0));
            buffer.add_products(|i, s, t| product(&vectors[i], [s, t]), sum);
        }
    }
}
