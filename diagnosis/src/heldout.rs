//! Residuals that were predicted from the other folds, sample by sample, and their intervals.

use crate::gram::{Columns, FOLDS, Gram, solve};
use crate::scene::{ROWS, SampleRows, Scene};
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
    /// Standard deviation of the row by the noise of its readings, m.
    pub noise_m: Vec<f64>,
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
            out.push(scene, i, &rows, &value);
        }
        out
    }

    /// Adds a sample's rows.
    pub fn push(&mut self, scene: &Scene, i: usize, rows: &SampleRows, value_m: &[f64; ROWS]) {
        let white = rows.whitened(value_m);
        let variance = scene.reading_variance(i);
        for row in 0..rows.count {
            self.sample.push(i);
            self.channel.push(rows.channel[row]);
            self.value_m.push(value_m[row]);
            self.white.push(white[row]);
            let parts = rows.by_reading[row].iter().zip(&variance);
            self.noise_m
                .push(parts.map(|(j, v)| j * j * v).sum::<f64>().sqrt());
        }
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
    pub fn foretold_m(&self, channel: usize) -> [f64; 2] {
        let here = self.channel_rms_m(channel).0;
        self.interval_m(channel)
            .map(|end| (here + (end - here) * std::f64::consts::SQRT_2).max(0.0))
    }

    /// 95 % interval of a channel's rms, m, by bootstrap over pieces. How far neighbours go together is not known beforehand: of
    /// several lengths of piece the one counts that scatters most (Flyvbjerg and Petersen 1989).
    pub fn interval_m(&self, channel: usize) -> [f64; 2] {
        PIECES
            .iter()
            .map(|length| self.pieces(channel, *length))
            .enumerate()
            .filter(|(k, pieces)| pieces.len() >= if *k == 0 { 2 } else { FEWEST })
            .map(|(_, pieces)| bootstrap(&pieces))
            .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
            .unwrap_or_default()
    }

    /// A channel's squares in pieces of so many samples of the recording: those of the residual, and of the noise.
    fn pieces(&self, channel: usize, length: usize) -> Vec<[f64; 3]> {
        let mut pieces: Vec<[f64; 3]> = Vec::new();
        let mut last = usize::MAX;
        for k in (0..self.sample.len()).filter(|k| self.channel[*k] == channel) {
            if self.sample[k] / length != last {
                pieces.push([0.0; 3]);
                last = self.sample[k] / length;
            }
            if let Some(piece) = pieces.last_mut() {
                let (value, noise) = (self.value_m[k], self.noise_m[k]);
                *piece = [
                    piece[0] + value * value,
                    piece[1] + noise * noise,
                    piece[2] + 1.0,
                ];
            }
        }
        pieces
    }
}

/// 95 % interval of the rms of what the pieces are drawn from, m: of its ratio to the noise, whose own rms is known and the same
/// whichever pieces are drawn.
fn bootstrap(pieces: &[[f64; 3]]) -> [f64; 2] {
    let sum = |list: &mut dyn Iterator<Item = &[f64; 3]>| {
        list.fold([0.0; 3], |sum, p| std::array::from_fn(|k| sum[k] + p[k]))
    };
    let [_, noise, count] = sum(&mut pieces.iter());
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut draws: Vec<f64> = (0..BOOTSTRAPS)
        .map(|_| {
            let mut drawn = (0..pieces.len()).map(|_| &pieces[index(&mut rng, pieces.len())]);
            let [square, its_noise, its_count] = sum(&mut drawn);
            let ratio = if noise > 0.0 {
                noise / its_noise
            } else {
                count / its_count
            };
            (square * ratio / count).sqrt()
        })
        .collect();
    draws.sort_by(f64::total_cmp);
    let tail = BOOTSTRAPS / 40;
    [draws[tail], draws[BOOTSTRAPS - 1 - tail]]
}

/// Draws of the bootstrap.
const BOOTSTRAPS: usize = 400;
/// Lengths of its pieces, samples, and the fewest pieces that a longer one may leave.
const PIECES: [usize; 3] = [50, 200, 500];
/// See [`PIECES`].
const FEWEST: usize = 16;
