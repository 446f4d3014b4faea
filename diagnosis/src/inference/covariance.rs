//! How well a model's amounts are known: their covariance as the recording left it, so that `check` can tell where another recording
//! asks for what the model's own one did not show. A claim is neither confirmed nor refuted there.
//!
//! By the priors of physical size: those that the recording itself has shrunk ([`crate::inference::ard`]) say of what it did not show
//! that it is nothing, which is a choice and no knowledge.

use crate::algebra::statistics::median;
use crate::design::gram::Columns;
use crate::linearization::recording::LinearizedRecording;
use crate::linearization::relinearized::RelinearizedFit;
use effects::random::{ChaCha8Rng, SeedableRng, normal};
use effects::sensor::{CHANNELS, Covariates, READINGS, Regressor};
use effects::{Card, Detection};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// A row is not foretold if the model's own uncertainty there is more than half of the noise: its square. Derived from what that
/// adds: a variance of 1.25 in the place of 1, 12 % in rms, where a claim is held to 10 %.
const UNKNOWN_VARIANCE_SHARE: f64 = 0.25;
/// Draws that tell a variance. Derived from chi-square: with 24 it is known to 29 %.
const COVARIANCE_DRAWS: usize = 24;
/// Digits of a correlation that are sure. Derived from 16 digits: of a covariance with a condition number of 1e6, as the joint
/// problem's, ten are left.
const CORRELATION_DIGITS: i32 = 10;
/// Blocks whose amounts are known in another way: by the places that were visited (a field on a mesh), or not at all elsewhere.
fn is_apart(name: &str) -> bool {
    effects::has(name, |card| {
        matches!(card.detection, Detection::AsField | Detection::ByLines)
            || card.keeps_its_own_time()
    })
}

/// Covariance of a model's amounts, the baseline's among them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PosteriorCovariance {
    /// Block and name of each amount.
    pub amounts: Vec<[String; 2]>,
    /// Lower triangle row by row, in the amounts' units; empty where there are [`Self::draws`].
    pub covariance: Vec<f64>,
    /// Draws from the amounts' distribution less its mean: of thousands of teeth, in the place of millions of covariances.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub draws: Vec<Vec<f32>>,
    /// Noise of each reading over the stated one, as the recording showed it.
    pub noise: [f64; READINGS],
}

impl PosteriorCovariance {
    /// Of a model fitted about itself. Cost: the cube of its columns. None where no effect's amounts are told by it.
    pub fn of(relinearized: &RelinearizedFit) -> Option<Self> {
        let columns = &relinearized.columns;
        let by_teeth = relinearized.linearized.inputs.teeth.is_some();
        let estimate =
            |name: &str| !is_apart(name) || by_teeth && effects::is(name, Detection::AsField);
        columns.blocks[1..].iter().find(|b| estimate(&b.name))?;
        // A drift's course is another elsewhere, as the claim says. Equation (3) is what is left at its mean, and no less known for that.
        let drift = columns
            .blocks
            .iter()
            .find(|b| effects::has(&b.name, Card::keeps_its_own_time));
        let all: Vec<usize> = (0..relinearized.gram.width())
            .filter(|c| drift.is_none_or(|b| !b.columns.contains(c)))
            .collect();
        let shrunk = &relinearized.gram.shrunk;
        let mut precision = relinearized.gram.training(None).square(&all);
        for (j, &a) in all.iter().enumerate() {
            for (k, &b) in all.iter().enumerate() {
                precision[(j, k)] /= shrunk[a] * shrunk[b];
            }
            precision[(j, j)] += 1.0;
        }
        let factor = Factor::new(precision)?;
        let unit = |c: usize| relinearized.gram.scale[c] / shrunk[c];
        let mut out = Self {
            noise: relinearized.linearized.noise,
            ..Self::default()
        };
        let mut list = Vec::new();
        for block in columns.blocks.iter().filter(|b| estimate(&b.name)) {
            for c in block.columns.clone() {
                let name = columns.regressors[c].name.clone();
                out.amounts.push([block.name.clone(), name]);
                list.extend(all.iter().position(|a| *a == c).map(|k| (k, c)));
            }
        }
        if by_teeth {
            let mut rng = ChaCha8Rng::seed_from_u64(COVARIANCE_DRAWS as u64);
            for _ in 0..COVARIANCE_DRAWS {
                let draw = DVector::from_fn(all.len(), |_, _| normal(&mut rng));
                let draw = factor.coloured(&draw);
                // A float's digits are enough, and half of the file.
                let short = |(k, c): &(usize, usize)| (draw[*k] * unit(*c)) as f32;
                out.draws.push(list.iter().map(short).collect());
            }
            return Some(out);
        }
        let covariance = factor.inverse();
        for (last, &(j, c)) in list.iter().enumerate() {
            let row = list[..=last].iter();
            out.covariance
                .extend(row.map(|&(k, other)| covariance[(j, k)] * unit(c) * unit(other)));
        }
        Some(out)
    }

    /// Samples of those in use where some row is not foretold. What the rows of a channel have in common is a zero, which is
    /// arbitrary from one recording to the next. Cost: rows times the amounts that act times the directions.
    pub fn extrapolates(&self, linearized: &LinearizedRecording, columns: &Columns) -> Vec<bool> {
        let directions = self.directions();
        let places: HashMap<&[String; 2], usize> = self.amounts.iter().zip(0..).collect();
        let mut known: Vec<(&Regressor, &Vec<f64>)> = Vec::new();
        for block in &columns.blocks {
            for c in block.columns.clone() {
                let name = [block.name.clone(), columns.regressors[c].name.clone()];
                if let Some(&place) = places.get(&name) {
                    known.push((&columns.regressors[c], &directions[place]));
                }
            }
        }
        let count = directions.first().map_or(0, Vec::len);
        let samples: Vec<usize> = (0..linearized.len())
            .filter(|&i| linearized.mask[i])
            .collect();
        let one = |i: &usize| {
            let rows = linearized.rows(*i);
            let covariates: Covariates = linearized.covariates(*i);
            let by_reading = rows.white_by_reading();
            let mut out = vec![vec![0.0; count]; rows.count];
            for (regressor, along) in &known {
                let Some(white) = rows.white_response(&by_reading, regressor, &covariates) else {
                    continue;
                };
                for (row, slope) in out.iter_mut().zip(white) {
                    row.iter_mut()
                        .zip(*along)
                        .for_each(|(sum, along)| *sum += slope * along);
                }
            }
            (rows.channel, out)
        };
        let rows: Vec<_> = samples.par_iter().map(one).collect();
        // Their median along each direction: rows of which nothing is known would draw a mean away.
        let zeros: Vec<Vec<f64>> = (0..CHANNELS)
            .map(|channel| {
                let of = rows
                    .iter()
                    .flat_map(|(channels, list)| list.iter().zip(channels));
                let list: Vec<&Vec<f64>> = of.filter(|r| *r.1 == channel).map(|r| r.0).collect();
                let of_direction = |k: usize| {
                    let mut values: Vec<f64> = list.iter().map(|row| row[k]).collect();
                    median(&mut values).unwrap_or(0.0)
                };
                (0..count).map(of_direction).collect()
            })
            .collect();
        let mut out = vec![false; linearized.len()];
        for (i, (channel, list)) in samples.into_iter().zip(rows) {
            out[i] = list.iter().zip(channel).any(|(row, channel)| {
                let off = row.iter().zip(&zeros[channel]);
                let squares: f64 = off.map(|(value, zero)| (value - zero).powi(2)).sum();
                squares > UNKNOWN_VARIANCE_SHARE
            });
        }
        out
    }

    /// What independent unit numbers move each amount by: a root of the covariance, or its draws, whose mean square it is.
    fn directions(&self) -> Vec<Vec<f64>> {
        if !self.draws.is_empty() {
            let share = 1.0 / (self.draws.len() as f64).sqrt();
            let of = |place: usize| self.draws.iter().map(move |d| share * f64::from(d[place]));
            return (0..self.amounts.len()).map(|a| of(a).collect()).collect();
        }
        let n = self.amounts.len();
        let element = |a: usize, b: usize| {
            let (high, low) = (a.max(b), a.min(b));
            let value = self.covariance.get(high * (high + 1) / 2 + low);
            value.copied().unwrap_or(0.0)
        };
        let size = |a: usize| element(a, a).sqrt().max(f64::MIN_POSITIVE);
        let related = DMatrix::from_fn(n, n, |a, b| element(a, b) / size(a) / size(b));
        // What rounding took from amounts that cancel is given back.
        let mended = |digits: i32| {
            let given = DMatrix::identity(n, n) * 10f64.powi(-digits);
            (&related + given).cholesky()
        };
        let root = (0..=CORRELATION_DIGITS)
            .rev()
            .find_map(mended)
            .map(|root| root.l());
        let of = |a: usize, b: usize| root.as_ref().map_or(0.0, |root| size(a) * root[(a, b)]);
        (0..n).map(|a| (0..n).map(|b| of(a, b)).collect()).collect()
    }
}
