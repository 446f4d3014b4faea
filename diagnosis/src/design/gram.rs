//! One pass over the samples: products of all columns, by fold, so that every later comparison is small algebra.

use crate::data::folds::FOLDS;
use crate::design::column_values::{by_source, in_order_of_sources, places, product};
use crate::design::training::Training;
use crate::linearization::groups::{GROUP_SAMPLES, Group, Sample};
use crate::linearization::recording::{LinearizedRecording, SOURCES, TARGET};
use effects::sensor::{CHANNELS, Covariates, READINGS, Regressor};
use normal_equations::by_source::SourceBuffer;
use normal_equations::symmetric::Symmetric;
use rayon::prelude::*;
use std::ops::Range;
use tooth_field::order_of_places;

/// Samples that are turned into rows at once. Cost alone: the rows of a chunk stay in the processor's cache, and the sums, which do not,
/// are gone through once a chunk.
const CHUNK: usize = 256;
/// Sums that are formed side by side. Their number and what goes into each is the same on every machine and in every run, so that
/// the last digit is. Cost alone: as many processors have work.
const LANES: usize = 4;
/// The same of so many columns that each sum takes tens of megabytes. Cost alone: a sum of 1,000 columns takes 8 MB, of 2,400
/// (`MOST_TEETH`) 46 MB.
const FEWER_LANES: usize = 2;
/// See [`FEWER_LANES`].
const WIDE: usize = 1000;

/// What a group of columns stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Name: an effect's, or a coordinate's.
    pub name: String,
    /// Its columns.
    pub columns: Range<usize>,
}

/// Products of all columns over some rows; the last column is the target.
#[derive(Clone, Debug)]
pub struct Products {
    /// `[columns + 1, columns + 1]`, of columns of one prior deviation each, in deviations of the noise.
    pub sum: Symmetric,
    /// Samples of them that saw the beacon.
    pub in_sight: usize,
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
        self.centre.extend(regressors.iter().map(|r| r.mean));
        self.held
            .extend(std::iter::repeat_n(false, regressors.len()));
        self.regressors.extend(regressors);
        self.blocks.push(Block {
            name: name.into(),
            columns: start..self.regressors.len(),
        });
        self.blocks.len() - 1
    }

    /// Appends the groups of others.
    pub fn append(&mut self, others: Self) {
        let start = self.regressors.len();
        let moved = |b: Block| Block {
            columns: start + b.columns.start..start + b.columns.end,
            ..b
        };
        self.blocks.extend(others.blocks.into_iter().map(moved));
        self.regressors.extend(others.regressors);
        self.centre.extend(others.centre);
        self.held.extend(others.held);
    }
}

/// Products of whitened columns by fold; the last column is the target, minus the residual.
pub struct Gram {
    /// `[fold]`, each `[columns + 1, columns + 1]`, of columns scaled by their prior deviation; none where only the sum was asked for.
    pub fold: Vec<Symmetric>,
    /// Their sum.
    pub(crate) total: Symmetric,
    /// Rows in each fold, or in all.
    pub rows: Vec<usize>,
    /// Prior deviation of each amount: a column times this is one prior deviation of effect.
    pub scale: Vec<f64>,
    /// Prior mean, in prior deviations.
    pub centre: Vec<f64>,
    /// Prior deviation over the physical one.
    pub shrunk: Vec<f64>,
    /// True if the readings show less noise than is stated: less than the stated noise may be left.
    pub overstated: bool,
    /// True if the noise is what was found in the residuals and not what is stated: it may hold some of what it hides.
    pub loud: bool,
}

/// Keys of samples by which those over the same part of the platen follow each other: then few of many teeth act in a chunk.
fn by_place(linearized: &LinearizedRecording) -> Vec<u64> {
    let pitch_m = linearized.observations.pitch_m;
    let key = |i| order_of_places(linearized.refined_centre_m(i).map(|c| c / pitch_m));
    (0..linearized.len()).map(key).collect()
}

/// Sums of a channel's squares and values, and how many there were.
type ChannelSums = [(f64, f64, usize); CHANNELS];

/// Spread of each column's response over the rows where it acts, m: of g_p where it acts there, else of the largest channel.
fn sizes(linearized: &LinearizedRecording, columns: &Columns) -> Vec<f64> {
    let step = (linearized.len() / 3000).max(1);
    let list: Vec<usize> = (0..linearized.len()).step_by(step).collect();
    let parts = list.par_chunks(list.len().div_ceil(LANES).max(1));
    let parts: Vec<Vec<ChannelSums>> = parts
        .map(|part| spreads(linearized, columns, part))
        .collect();
    let total = |c: usize| {
        let mut sum = ChannelSums::default();
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

fn spreads(
    linearized: &LinearizedRecording,
    columns: &Columns,
    samples: &[usize],
) -> Vec<ChannelSums> {
    let regressors = &columns.regressors;
    let mut sums = vec![ChannelSums::default(); regressors.len()];
    for samples in samples.chunks(GROUP_SAMPLES) {
        let group = Group::new(
            linearized,
            regressors,
            0..regressors.len(),
            samples.iter().copied(),
        );
        // The samples of one column follow one another: its function and its sums stay at hand.
        for &c in &group.acting {
            for Sample {
                rows, covariates, ..
            } in &group.samples
            {
                let response = rows.response(&regressors[c], covariates);
                for (a, channel) in response.iter().zip(rows.channel).take(rows.count) {
                    if *a != 0.0 {
                        sums[c][channel].0 += a * a;
                        sums[c][channel].1 += a;
                        sums[c][channel].2 += 1;
                    }
                }
            }
        }
    }
    sums
}

fn size(sum: &ChannelSums) -> f64 {
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
    pub fn new(linearized: &LinearizedRecording, columns: &Columns, folds: &[u8]) -> Self {
        let mut sums = Sums::new(linearized, columns);
        let scale = sums.priors();
        let parts = (0..FOLDS).map(|f| sums.over(&scale, |i| usize::from(folds[i]) == f));
        let (fold, rows): (Vec<Symmetric>, Vec<usize>) = parts.unzip();
        let mut total = Symmetric::zeros(scale.len() + 1);
        fold.iter().for_each(|f| total += f);
        Self::of(linearized, columns, scale, (fold, rows, total))
    }

    /// The same without the folds by themselves: a sixth of the memory.
    pub fn without_folds(linearized: &LinearizedRecording, columns: &Columns) -> Self {
        let mut sums = Sums::new(linearized, columns);
        let scale = sums.priors();
        let (total, rows) = sums.over(&scale, |_| true);
        Self::of(linearized, columns, scale, (Vec::new(), vec![rows], total))
    }

    /// What is asked of the products of all folds but each. Where the folds are not kept their products are formed anew, one after the
    /// other.
    pub fn by_folds<R: Send>(
        &self,
        linearized: &LinearizedRecording,
        columns: &Columns,
        folds: &[u8],
        asked: impl Fn(Training) -> R + Sync,
    ) -> Vec<R> {
        let without = |test: &Symmetric| asked(Training::new(&self.total, Some(test)));
        if !self.fold.is_empty() {
            return self.fold.par_iter().map(without).collect();
        }
        let mut sums = Sums::new(linearized, columns);
        let mut test = |f| sums.over(&self.scale, |i| usize::from(folds[i]) == f).0;
        (0..FOLDS).map(|f| without(&test(f))).collect()
    }

    fn of(
        linearized: &LinearizedRecording,
        columns: &Columns,
        scale: Vec<f64>,
        (fold, rows, total): (Vec<Symmetric>, Vec<usize>, Symmetric),
    ) -> Self {
        let centre = columns
            .centre
            .iter()
            .zip(&scale)
            .map(|(c, s)| if *s > 0.0 { c / s } else { 0.0 })
            .collect();
        Self {
            fold,
            total,
            rows,
            shrunk: vec![1.0; scale.len()],
            scale,
            centre,
            overstated: linearized.observations.overstated,
            loud: linearized.noise != [1.0; READINGS],
        }
    }

    /// Takes prior deviations to be so many times what they were; prior means stay what they are in their units.
    pub fn rescale(&mut self, factor: &[f64]) {
        for (c, by) in factor.iter().enumerate().filter(|(_, by)| **by != 1.0) {
            self.scale[c] *= by;
            self.shrunk[c] *= by;
            self.centre[c] /= by;
            for sum in self.fold.iter_mut().chain([&mut self.total]) {
                sum.rescale(c, *by);
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

    /// Sum over all folds but one (or all). Folds must have been kept for one to be left out.
    pub fn training(&self, without: Option<usize>) -> Training<'_> {
        Training::new(&self.total, without.map(|fold| &self.fold[fold]))
    }
}

/// Products over parts of the samples in use, one part after the other: their memory serves all.
struct Sums<'s, 'a> {
    linearized: &'s LinearizedRecording<'a>,
    columns: &'s Columns,
    lanes: Vec<PartialSums>,
    order: Option<Vec<u64>>,
    /// Columns in the order in which their products are formed.
    in_order: Vec<usize>,
    /// Place of each column in it.
    place: Vec<usize>,
}

/// Sums that are formed beside others.
struct PartialSums {
    buffer: SourceBuffer,
    /// Of the columns in their order.
    sum: Symmetric,
    rows: usize,
}

impl PartialSums {
    fn new(width: usize) -> Self {
        Self {
            buffer: SourceBuffer::new(SOURCES),
            sum: Symmetric::zeros(width),
            rows: 0,
        }
    }
}

impl<'s, 'a> Sums<'s, 'a> {
    fn new(linearized: &'s LinearizedRecording<'a>, columns: &'s Columns) -> Self {
        let width = columns.regressors.len() + 1;
        let lanes = if width > WIDE { FEWER_LANES } else { LANES };
        let in_order = in_order_of_sources(&columns.regressors);
        Self {
            place: places(&in_order),
            in_order,
            linearized,
            columns,
            lanes: (0..lanes).map(|_| PartialSums::new(width)).collect(),
            order: linearized
                .inputs
                .teeth
                .as_ref()
                .map(|_| by_place(linearized)),
        }
    }

    /// Prior deviation of each amount.
    fn priors(&self) -> Vec<f64> {
        let sizes = sizes(self.linearized, self.columns);
        let prior = |(r, s): (&Regressor, f64)| match r.deviation {
            _ if s <= 0.0 => 0.0,
            Some(deviation) => deviation,
            None => r.size_m / s,
        };
        self.columns
            .regressors
            .iter()
            .zip(sizes)
            .map(prior)
            .collect()
    }

    /// Products over the samples that are asked for, and their rows, by lanes side by side.
    fn over(&mut self, scale: &[f64], asked: impl Fn(usize) -> bool) -> (Symmetric, usize) {
        let (linearized, columns) = (self.linearized, self.columns);
        let in_order = &self.in_order;
        let mut samples: Vec<usize> = (0..linearized.len())
            .filter(|&i| linearized.mask[i] && asked(i))
            .collect();
        if let Some(order) = &self.order {
            samples.sort_by_key(|i| order[*i]);
        }
        let every = self.lanes.len();
        // On the threads of the caller's pool: one alone where recordings are diagnosed side by side.
        let lanes = self.lanes.par_iter_mut().enumerate();
        lanes.with_max_len(1).for_each(|(number, lane)| {
            for chunk in samples.chunks(CHUNK).skip(number).step_by(every) {
                lane.rows += accumulate(linearized, columns, in_order, scale, chunk, lane);
            }
        });
        let (first, others) = self.lanes.split_first_mut().expect("a lane or more");
        let mut rows = std::mem::take(&mut first.rows);
        for lane in others {
            first.sum += &lane.sum;
            lane.sum.clear();
            rows += std::mem::take(&mut lane.rows);
        }
        let sum = first.sum.reordered(&self.place);
        first.sum.clear();
        (sum, rows)
    }
}

/// Adds a chunk's products. Columns that are zero throughout the chunk (shapes of another run, of
/// another time, of another place) cost nothing but their evaluation.
fn accumulate(
    linearized: &LinearizedRecording,
    columns: &Columns,
    in_order: &[usize],
    scale: &[f64],
    samples: &[usize],
    lane: &mut PartialSums,
) -> usize {
    let (regressors, last) = (&columns.regressors, scale.len());
    let group = Group::new(linearized, regressors, 0..last, samples.iter().copied());
    let covariates: Vec<&Covariates> = group.samples.iter().map(|s| &s.covariates).collect();
    let vectors: Vec<_> = group
        .samples
        .iter()
        .map(|s| s.rows.white_sources())
        .collect();
    let buffer = &mut lane.buffer;
    buffer.begin(covariates.len());
    let mut acting = vec![false; last + 1];
    group.acting.iter().for_each(|c| acting[*c] = true);
    for (place, &c) in in_order.iter().enumerate().filter(|(_, c)| acting[**c]) {
        for (source, values) in by_source(&regressors[c], &covariates) {
            buffer.push(source, place, values.into_iter().map(|v| v * scale[c]));
        }
    }
    buffer.push(TARGET, last, covariates.iter().map(|_| 1.0));
    buffer.add_products(|i, s, t| product(&vectors[i], [s, t]), &mut lane.sum);
    group.samples.iter().map(|s| s.rows.count).sum()
}

/// Products of each of some parts of the samples, and the prior deviation of each amount. `part` is one number a sample.
pub fn products_by_part(
    linearized: &LinearizedRecording,
    columns: &Columns,
    part: &[u16],
    parts: usize,
) -> (Vec<Products>, Vec<f64>) {
    let mut sums = Sums::new(linearized, columns);
    let deviations = sums.priors();
    let mut products = |number: usize| {
        let (sum, _) = sums.over(&deviations, |i| usize::from(part[i]) == number);
        let of_it = (0..part.len()).filter(|i| usize::from(part[*i]) == number);
        let in_sight = of_it.filter(|i| linearized.channels(*i)[1]).count();
        Products { sum, in_sight }
    };
    ((0..parts).map(&mut products).collect(), deviations)
}
