//! Residuals that were predicted from the other folds, sample by sample, and their intervals.

use crate::design::gram::{Columns, Gram};
use crate::design::training::Training;
use crate::inference::bootstrap::{estimated, foretold, other_runs};
use crate::inference::fit::solve;
use crate::linearization::groups::{GROUP_SAMPLES, Group, Sample};
use crate::linearization::recording::{LinearizedRecording, ROWS, SampleRows};
use effects::sensor::CHANNELS;
use rayon::prelude::*;

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
        linearized: &LinearizedRecording,
        columns: &Columns,
        gram: &Gram,
        folds: &[u8],
        list: &[usize],
    ) -> Self {
        let amounts = |training: Training| {
            let fit = solve(training, list, &gram.centre, 1.0);
            fit.map_or(vec![0.0; list.len()], |fit| {
                fit.coefficient.as_slice().to_vec()
            })
        };
        let coefficients = gram.by_folds(linearized, columns, folds, amounts);
        Self::predicted(
            linearized,
            columns,
            gram,
            list,
            |i| &coefficients[usize::from(folds[i])],
            false,
        )
    }

    /// Sample, channel and whitened residual of each row.
    pub fn white_rows(&self) -> Vec<(usize, usize, f64)> {
        let rows = self.sample.iter().zip(&self.channel).zip(&self.white);
        rows.map(|((i, channel), white)| (*i, *channel, *white))
            .collect()
    }

    /// Some of them.
    pub fn only(&self, stays: impl Fn(usize) -> bool) -> Self {
        let list: Vec<usize> = (0..self.sample.len()).filter(|k| stays(*k)).collect();
        let values = |of: &[f64]| list.iter().map(|k| of[*k]).collect();
        Self {
            sample: list.iter().map(|k| self.sample[*k]).collect(),
            channel: list.iter().map(|k| self.channel[*k]).collect(),
            value_m: values(&self.value_m),
            white: values(&self.white),
            noise_m: values(&self.noise_m),
        }
    }

    /// The same with each channel's whitened rms made one.
    pub fn of_unit_rms(&self) -> Self {
        let mut out = self.clone();
        for channel in self.channels() {
            let of = |k: &usize| self.channel[*k] == channel;
            let list: Vec<usize> = (0..self.white.len()).filter(of).collect();
            let rms =
                crate::algebra::statistics::rms(list.iter().map(|k| self.white[*k])).max(1e-12);
            list.iter().for_each(|k| out.white[*k] /= rms);
        }
        out
    }

    /// Of given amounts (in prior deviations), the same at every sample.
    pub fn predicted<'b>(
        linearized: &LinearizedRecording,
        columns: &Columns,
        gram: &Gram,
        list: &[usize],
        coefficient: impl Fn(usize) -> &'b Vec<f64> + Sync,
        all: bool,
    ) -> Self {
        let samples: Vec<usize> = (0..linearized.len())
            .filter(|&i| all || linearized.mask[i])
            .collect();
        let mut place = vec![0; columns.regressors.len()];
        list.iter().enumerate().for_each(|(k, c)| place[*c] = k);
        let parts = samples.par_chunks(GROUP_SAMPLES).map(|part| {
            let asked = list.iter().copied();
            let group = Group::new(linearized, &columns.regressors, asked, part.iter().copied());
            let mut out = Self::default();
            for Sample {
                number,
                rows,
                covariates,
            } in &group.samples
            {
                let mut value: [f64; ROWS] = rows.residual_m;
                let coefficients = coefficient(*number);
                for &c in &group.acting {
                    let step = coefficients[place[c]] * gram.scale[c];
                    if step != 0.0 {
                        let response = rows.response(&columns.regressors[c], covariates);
                        for row in 0..rows.count {
                            value[row] += step * response[row];
                        }
                    }
                }
                out.push(linearized, *number, rows, &value);
            }
            out
        });
        Self::joined(&parts.collect::<Vec<Self>>())
    }

    /// Residuals of parts of a recording, one after the other.
    pub fn joined(parts: &[Self]) -> Self {
        let mut out = Self::default();
        for part in parts {
            out.sample.extend(&part.sample);
            out.channel.extend(&part.channel);
            out.value_m.extend(&part.value_m);
            out.white.extend(&part.white);
            out.noise_m.extend(&part.noise_m);
        }
        out
    }

    /// Adds a sample's rows.
    pub fn push(
        &mut self,
        linearized: &LinearizedRecording,
        i: usize,
        rows: &SampleRows,
        value_m: &[f64; ROWS],
    ) {
        let white = rows.whitened(value_m);
        let variance = linearized.reading_variance(i);
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

    /// The same residuals whitened by the noise of another linearization of the same recording.
    pub fn rewhitened(&self, linearized: &LinearizedRecording) -> Self {
        self.changed(linearized, |_| [0.0; ROWS])
    }

    /// The same with something added to each sample's rows, m, and whitened by the noise of a linearized recording.
    pub fn changed(
        &self,
        linearized: &LinearizedRecording,
        added: impl Fn(usize) -> [f64; ROWS],
    ) -> Self {
        let mut out = self.clone();
        let mut start = 0;
        while start < self.sample.len() {
            let i = self.sample[start];
            let rows = linearized.rows(i);
            let end = (start + rows.count.max(1)).min(self.sample.len());
            let mut value = [0.0; ROWS];
            let here = self.value_m[start..end].iter().zip(added(i));
            for (value, (before, added)) in value.iter_mut().zip(here) {
                *value = before + added;
            }
            out.value_m[start..end].copy_from_slice(&value[..end - start]);
            out.white[start..end].copy_from_slice(&rows.whitened(&value)[..end - start]);
            start = end;
        }
        out
    }

    /// Rms of a channel, m, and its number of samples.
    pub fn channel_rms_m(&self, channel: usize) -> (f64, usize) {
        let values: Vec<f64> = self.of(channel).map(|(_, v)| v).collect();
        (
            crate::algebra::statistics::rms(values.iter().copied()),
            values.len(),
        )
    }

    /// Rms of all whitened residuals.
    pub fn white_rms(&self) -> f64 {
        crate::algebra::statistics::rms(self.white.iter().copied())
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

    /// 95 % interval for a channel's rms on another recording of as many runs of this kind, m: both scatter, and the noise is
    /// another one in each run, with the places that it passes. Whole folds that a model has not seen may show that it goes wrong
    /// beside the places that it was fitted on: `folds_m` is what it leaves there, and another recording is expected between the
    /// two. `run` is that of each sample.
    pub fn predicted_rms_m(&self, channel: usize, folds_m: f64, run: &[usize]) -> [f64; 2] {
        let here = self.channel_rms_m(channel).0;
        if here <= 0.0 {
            return [0.0; 2];
        }
        let runs = self.noise_of_runs(channel, run);
        let other = other_runs(&runs) * Self::noise_share(&runs, here);
        let [less, more] = self
            .widest(channel, foretold)
            .map(|end| end.ln().hypot(other).exp());
        [here / less, here * more * (folds_m / here).max(1.0)]
    }

    /// Of a squared rms, m, what is the noise's: what else is left does not follow the noise from run to run.
    fn noise_share(runs: &[[f64; 2]], rms_m: f64) -> f64 {
        let [square, count] = runs
            .iter()
            .fold([0.0; 2], |s, r| [s[0] + r[0], s[1] + r[1]]);
        (square / f64::max(count, 1.0) / (rms_m * rms_m)).min(1.0)
    }

    /// Squares of a channel's noise in each run, and their number.
    fn noise_of_runs(&self, channel: usize, run: &[usize]) -> Vec<[f64; 2]> {
        let mut runs: Vec<[f64; 2]> = Vec::new();
        for k in (0..self.sample.len()).filter(|k| self.channel[*k] == channel) {
            let number = run[self.sample[k]];
            if runs.len() <= number {
                runs.resize(number + 1, [0.0; 2]);
            }
            runs[number][0] += self.noise_m[k].powi(2);
            runs[number][1] += 1.0;
        }
        runs.retain(|r| r[1] > 0.0 && r[0] > 0.0);
        runs
    }

    /// 95 % interval of a channel's rms, m, by bootstrap over pieces.
    pub fn interval_m(&self, channel: usize) -> [f64; 2] {
        let here = self.channel_rms_m(channel).0;
        // Of readings that are compared with themselves nothing is left, and nothing scatters.
        if here <= 0.0 {
            return [0.0; 2];
        }
        self.widest(channel, estimated).map(|end| here * end)
    }

    /// An interval from pieces of a channel. How far neighbours go together is not known beforehand: of several lengths of piece
    /// the one counts that scatters most (Flyvbjerg and Petersen 1989).
    fn widest(&self, channel: usize, interval: impl Fn(&[[f64; 3]]) -> [f64; 2]) -> [f64; 2] {
        PIECE_LENGTHS
            .iter()
            .map(|length| self.pieces(channel, *length))
            .enumerate()
            .filter(|(k, pieces)| pieces.len() >= if *k == 0 { 2 } else { FEWEST_PIECES })
            .map(|(_, pieces)| interval(&pieces))
            .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
            .unwrap_or([1.0; 2])
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

/// Lengths of the bootstrap's pieces, samples, and the fewest pieces that a longer one may leave.
const PIECE_LENGTHS: [usize; 4] = [50, 200, 500, 1500];
/// Fewest pieces that a longer one may leave. Derived from their scatter, which is known to 27 % of eight.
const FEWEST_PIECES: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Residuals that go together over some samples, of a noise that changes from place to place and from run to run.
    fn recording(samples: usize, seed: u64) -> (Residuals, Vec<usize>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut out = Residuals::default();
        let mut state = normal(&mut rng);
        let (mut run_m, mut noise_m) = (1.0, 1.0);
        for i in 0..samples {
            if i % (samples / RUNS) == 0 {
                run_m = (0.05 * normal(&mut rng)).exp();
            }
            if i % 250 == 0 {
                noise_m = run_m * (0.2 * normal(&mut rng)).exp();
            }
            state = NEIGHBOUR_CORRELATION * state
                + (1.0 - NEIGHBOUR_CORRELATION * NEIGHBOUR_CORRELATION).sqrt() * normal(&mut rng);
            out.sample.push(i);
            out.channel.push(0);
            out.value_m.push(noise_m * state);
            out.white.push(state);
            out.noise_m.push(noise_m);
        }
        let run = (0..samples).map(|i| i * RUNS / samples).collect();
        (out, run)
    }

    /// Runs of a recording.
    const RUNS: usize = 4;
    /// Correlation of neighbours.
    const NEIGHBOUR_CORRELATION: f64 = 0.9;
    /// Pairs of recordings.
    const PAIRS: u64 = 300;

    #[test]
    fn another_recording_is_within_what_is_foretold_as_often_as_is_claimed() {
        for samples in [3_000, 12_000] {
            let covered = (0..PAIRS).filter(|seed| {
                let [here, there] = [0, 1].map(|k| recording(samples, 2 * seed + k));
                let [low, high] = here.0.predicted_rms_m(0, 0.0, &here.1);
                (low..=high).contains(&there.0.channel_rms_m(0).0)
            });
            // 95 % of them, less three standard deviations of their binomial number.
            let pairs = PAIRS as f64;
            let least = 0.95 * pairs - 3.0 * (0.95 * 0.05 * pairs).sqrt();
            let covered = covered.count();
            assert!(
                covered as f64 >= least,
                "{covered} of {PAIRS}, {samples} samples"
            );
        }
    }

    #[test]
    fn residuals_that_are_all_zero_have_an_interval_of_no_width() {
        let (mut residuals, _) = recording(3_000, 1);
        residuals.value_m.fill(0.0);
        assert_eq!(residuals.interval_m(0), [0.0; 2]);
    }

    #[test]
    fn a_gap_far_over_the_noise_does_not_follow_it_from_run_to_run() {
        let (mut residuals, run) = recording(3_000, 1);
        let one_run = vec![0; 3_000];
        for (noise_m, run) in residuals.noise_m.iter_mut().zip(&run) {
            *noise_m = 1e-3 * 4.0_f64.powi(*run as i32);
        }
        let [low, high] = residuals.predicted_rms_m(0, 0.0, &run);
        let [less, more] = residuals.predicted_rms_m(0, 0.0, &one_run);
        assert!(
            high - low < 1.01 * (more - less),
            "{low} to {high}, {less} to {more}"
        );
    }
}
