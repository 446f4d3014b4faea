//! Residuals that were predicted from the other folds, sample by sample, and their intervals.

use crate::gram::{Columns, FOLDS, Gram, solve};
use crate::scene::{ROWS, Scene};
use effects::random::{ChaCha8Rng, SeedableRng, index};
use effects::sensor::CHANNELS;

/// Held-out residuals of one model.
#[derive(Clone, Debug, Default)]
pub struct Residuals {
    /// Sample of each row.
    pub sample: Vec<usize>,
    /// Channel of each row.
    pub channel: Vec<usize>,
    /// Residual, m.
    pub value_m: Vec<f64>,
    /// The same whitened within its sample.
    pub white: Vec<f64>,
}

impl Residuals {
    /// Of the model with these columns, each fold fitted on the others.
    pub fn new(
        scene: &Scene,
        columns: &Columns,
        gram: &Gram,
        folds: &[u8],
        list: &[usize],
    ) -> Self {
        let amounts: Vec<Vec<f64>> = (0..FOLDS)
            .map(|f| {
                solve(&gram.training(Some(f)), list, &gram.centre, 1.0)
                    .map_or(vec![0.0; list.len()], |fit| {
                        fit.amount.iter().copied().collect()
                    })
            })
            .collect();
        Self::predicted(
            scene,
            columns,
            gram,
            list,
            |i| &amounts[usize::from(folds[i])],
            false,
        )
    }

    /// Of given amounts (in prior deviations), the same at every sample.
    pub fn predicted<'b>(
        scene: &Scene,
        columns: &Columns,
        gram: &Gram,
        list: &[usize],
        amount: impl Fn(usize) -> &'b Vec<f64>,
        all: bool,
    ) -> Self {
        let mut out = Self::default();
        for i in (0..scene.len()).filter(|&i| all || scene.keep[i]) {
            let rows = scene.rows(i);
            if rows.count == 0 {
                continue;
            }
            let moment = scene.moment(i);
            let mut value: [f64; ROWS] = rows.residual_m;
            for (&c, a) in list.iter().zip(amount(i)) {
                let step = a * gram.scale[c];
                if step != 0.0 {
                    let response = rows.response(&columns.regressors[c], &moment);
                    for row in 0..rows.count {
                        value[row] += step * response[row];
                    }
                }
            }
            let white = rows.whitened(&value);
            for row in 0..rows.count {
                out.sample.push(i);
                out.channel.push(rows.channel[row]);
                out.value_m.push(value[row]);
                out.white.push(white[row]);
            }
        }
        out
    }

    /// The same residuals whitened by the noise of another scene of the same recording.
    pub fn rewhitened(&self, scene: &Scene) -> Self {
        let mut out = self.clone();
        let mut start = 0;
        while start < self.sample.len() {
            let i = self.sample[start];
            let rows = scene.rows(i);
            let end = (start + rows.count.max(1)).min(self.sample.len());
            let mut value = [0.0; ROWS];
            value[..end - start].copy_from_slice(&self.value_m[start..end]);
            out.white[start..end].copy_from_slice(&rows.whitened(&value)[..end - start]);
            start = end;
        }
        out
    }

    /// Rms of a channel, m, and its number of samples.
    pub fn channel_rms_m(&self, channel: usize) -> (f64, usize) {
        let values: Vec<f64> = self.of(channel).map(|(_, v)| v).collect();
        (crate::statistics::rms(values.iter().copied()), values.len())
    }

    /// Rms of all whitened residuals.
    pub fn white_rms(&self) -> f64 {
        crate::statistics::rms(self.white.iter().copied())
    }

    fn of(&self, channel: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.sample
            .iter()
            .zip(&self.channel)
            .zip(&self.value_m)
            .filter(move |((_, c), _)| **c == channel)
            .map(|((i, _), v)| (*i, *v))
    }

    /// Channels that have rows.
    pub fn channels(&self) -> Vec<usize> {
        (0..CHANNELS).filter(|c| self.channel.contains(c)).collect()
    }

    /// 95 % interval for a channel's rms on another recording of this length, m: both scatter.
    pub fn foretold_m(&self, channel: usize, length: usize) -> [f64; 2] {
        let here = self.channel_rms_m(channel).0;
        self.interval_m(channel, length)
            .map(|end| (here + (end - here) * std::f64::consts::SQRT_2).max(0.0))
    }

    /// 95 % interval of a channel's rms, m, by bootstrap over pieces of `length` samples.
    pub fn interval_m(&self, channel: usize, length: usize) -> [f64; 2] {
        let mut pieces: Vec<(f64, f64)> = Vec::new();
        let mut last = usize::MAX;
        for (i, v) in self.of(channel) {
            if i / length != last {
                pieces.push((0.0, 0.0));
                last = i / length;
            }
            if let Some(piece) = pieces.last_mut() {
                piece.0 += v * v;
                piece.1 += 1.0;
            }
        }
        if pieces.len() < 2 {
            return [0.0, 0.0];
        }
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut draws: Vec<f64> = (0..BOOTSTRAPS)
            .map(|_| {
                let (mut sum, mut count) = (0.0, 0.0);
                for _ in 0..pieces.len() {
                    let piece = pieces[index(&mut rng, pieces.len())];
                    sum += piece.0;
                    count += piece.1;
                }
                (sum / f64::max(count, 1.0)).sqrt()
            })
            .collect();
        draws.sort_by(f64::total_cmp);
        [
            draws[BOOTSTRAPS / 40],
            draws[BOOTSTRAPS - 1 - BOOTSTRAPS / 40],
        ]
    }
}

/// Draws of the bootstrap.
const BOOTSTRAPS: usize = 400;
