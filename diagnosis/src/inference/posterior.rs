//! How well a fit knows its amounts, and how much each effect does altogether on the recording's motion.
//!
//! The deviations are those of the fit's posterior covariance: of the stated noise (or of the one that the readings showed), the
//! motion, and the prior sizes of the amounts, times the Birge ratio where the model leaves more than the noise on held-out samples
//! ([`birge_ratio`]). The prior sizes go with what is left as well ([`crate::inference::ard`]), so that all of the covariance is scaled. They leave out noise that neighbouring samples have in common, that the prior
//! sizes were chosen from the same data, and that another effect might have been the cause.

use crate::inference::residuals::Residuals;
use crate::linearization::groups::{GROUP_SAMPLES, Group, Sample};
use crate::linearization::relinearized::RelinearizedFit;
use effects::sensor::CHANNELS;
use nalgebra::DVector;
use normal_equations::cholesky::Factor;

/// Most samples that a total is formed over. Derived from the scatter of an rms, 1/√(2n): of 4,000 it is known to 1.1 %.
const TOTAL_SAMPLES: usize = 4000;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// The Birge ratio of held-out residuals: root of their whitened squares per residual, and 1 where that is less. They took no part in
/// the fit, so that each counts as a degree of freedom. Deviations that are this many times as large fit what is left (Birge 1932,
/// "The calculation of errors by the method of least squares"; the scale factor of the Particle Data Group).
pub fn birge_ratio(held_out: &Residuals) -> f64 {
    held_out.white_rms().max(1.0)
}

/// The covariance of a fit's amounts, as the factor of its inverse.
pub struct Posterior<'f, 'a> {
    relinearized: &'f RelinearizedFit<'a>,
    factor: Factor,
}

impl<'f, 'a> Posterior<'f, 'a> {
    /// Of a fit, with deviations `birge_ratio` times those by the noise that the fit weighed by. Cost: a third of the cube of its
    /// columns. None where its normal equations cannot be solved.
    pub fn of(relinearized: &'f RelinearizedFit<'a>, birge_ratio: f64) -> Option<Self> {
        let all: Vec<usize> = (0..relinearized.gram.width()).collect();
        let mut precision = relinearized.gram.training(None).lower(&all);
        // The priors: unit deviations in the scale of the columns.
        (0..all.len()).for_each(|a| precision[(a, a)] += 1.0);
        precision /= birge_ratio * birge_ratio;
        let factor = Factor::new(precision)?;
        Some(Self {
            relinearized,
            factor,
        })
    }

    /// Standard deviation of an amount, in its own unit. Cost: the square of the columns.
    pub fn deviation(&self, column: usize) -> f64 {
        let gram = &self.relinearized.gram;
        let mut unit = DVector::zeros(gram.width());
        unit[column] = 1.0;
        self.factor.deviation(&unit) * gram.scale[column]
    }

    /// What a block of columns adds to the channels that it acts in, m rms over the samples in use, each channel about its mean: a
    /// constant is the channel's own zero.
    pub fn total_m(&self, block: usize) -> Estimate {
        let rows = self.rows(block);
        let mut sums = [[0.0; 2]; CHANNELS];
        for row in &rows {
            sums[row.channel][0] += row.value_m;
            sums[row.channel][1] += 1.0;
        }
        let mean = sums.map(|[sum, count]| sum / f64::max(count, 1.0));
        let acts = acting(&rows);
        let off = |row: &Row| row.value_m - mean[row.channel];
        let inside: Vec<&Row> = rows.iter().filter(|row| acts[row.channel]).collect();
        let count = inside.len().max(1) as f64;
        let square = inside.iter().map(|row| off(row).powi(2)).sum::<f64>() / count;
        let value = square.sqrt();
        if value <= 0.0 {
            return Estimate {
                value: 0.0,
                deviation: 0.0,
            };
        }
        // How the total changes with each amount, to first order.
        let mut slope = DVector::zeros(self.relinearized.gram.width());
        for row in &inside {
            for (column, response) in &row.by_amount {
                slope[*column] += off(row) * response / (count * value);
            }
        }
        Estimate {
            value,
            deviation: self.factor.deviation(&slope),
        }
    }

    /// What a block adds to each row of some samples, evenly spread.
    fn rows(&self, block: usize) -> Vec<Row> {
        let RelinearizedFit {
            linearized,
            columns,
            gram,
            coefficients,
            ..
        } = self.relinearized;
        let kept: Vec<usize> = (0..linearized.len())
            .filter(|&i| linearized.mask[i])
            .collect();
        let every = kept.len().div_ceil(TOTAL_SAMPLES).max(1);
        let some: Vec<usize> = kept.into_iter().step_by(every).collect();
        let mut out = Vec::new();
        for part in some.chunks(GROUP_SAMPLES) {
            let asked = columns.blocks[block].columns.clone();
            let group = Group::new(linearized, &columns.regressors, asked, part.iter().copied());
            for Sample {
                rows, covariates, ..
            } in &group.samples
            {
                let mut here: Vec<Row> = rows.channel[..rows.count]
                    .iter()
                    .map(|channel| Row::empty(*channel))
                    .collect();
                for &c in &group.acting {
                    let response = rows.response(&columns.regressors[c], covariates);
                    for (row, response) in here.iter_mut().zip(response) {
                        if response != 0.0 {
                            let scaled = response * gram.scale[c];
                            row.value_m += scaled * coefficients[c];
                            row.by_amount.push((c, scaled));
                        }
                    }
                }
                out.append(&mut here);
            }
        }
        out
    }
}

/// What a block adds to a row, m, and the part of each of its amounts, m a prior deviation.
struct Row {
    channel: usize,
    value_m: f64,
    by_amount: Vec<(usize, f64)>,
}

impl Row {
    fn empty(channel: usize) -> Self {
        Self {
            channel,
            value_m: 0.0,
            by_amount: Vec::new(),
        }
    }
}

/// Channels in which something is added anywhere.
fn acting(rows: &[Row]) -> [bool; CHANNELS] {
    let mut out = [false; CHANNELS];
    for row in rows.iter().filter(|row| row.value_m != 0.0) {
        out[row.channel] = true;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::prepare::prepare;
    use crate::design::assembly::{DesignOptions, Options, assemble};
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use recording::{Electronics, Geometry, Meta, Recording, Row as Reading, Samples};
    use std::f64::consts::TAU;

    const PITCH_M: f64 = 1.0e-3;
    const NOISE_M: f64 = 0.1e-6;
    const LATE_S: f64 = 50.0e-6;
    const TOTAL_SAMPLES: u32 = 600;
    /// Chosen: all samples take 3 s.
    const STEP_S: f64 = 5.0e-3;
    /// Way to either side, pitches.
    const WAY_PITCHES: f64 = 5.0;
    const SEEDS: u64 = 40;
    /// Chi-square with 40 degrees of freedom, which one draw in a hundred is below, and one above, as tables have it.
    const BY_CHANCE: [f64; 2] = [22.164, 63.691];
    /// The same with 39 degrees of freedom: a mean takes one.
    const ABOUT_THE_MEAN: [f64; 2] = [21.426, 62.428];

    /// Phase of the motion, rad, and its rate, rad/s: slow, then three times as fast, so that a delay is told from its bend over speed.
    fn phase(k: u32) -> (f64, f64) {
        let (half_s, t_s) = (
            0.5 * STEP_S * f64::from(TOTAL_SAMPLES),
            STEP_S * f64::from(k),
        );
        if k < TOTAL_SAMPLES / 2 {
            (0.8 * t_s, 0.8)
        } else {
            (0.8 * half_s + 2.4 * (t_s - half_s), 2.4)
        }
    }

    fn speed_m_s(k: u32) -> f64 {
        let (phase_rad, rate) = phase(k);
        WAY_PITCHES * PITCH_M * rate * phase_rad.sin()
    }

    /// A segment beside a reference, to and fro, late by [`LATE_S`]. Its noise is `louder` times what is stated.
    fn late(seed: u64, louder: f64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut samples = Samples::default();
        for k in 0..TOTAL_SAMPLES {
            let t_s = f64::from(k) * STEP_S;
            let reference_m = WAY_PITCHES * PITCH_M * (1.0 - phase(k).0.cos());
            let error_m = 3.0e-6 * (TAU * reference_m / PITCH_M).sin();
            let noise_m = louder * NOISE_M * normal(&mut rng);
            let read_m = reference_m + error_m - LATE_S * speed_m_s(k) + noise_m;
            samples.push(&Reading {
                t_s,
                run: if k < TOTAL_SAMPLES / 2 {
                    "there"
                } else {
                    "back"
                },
                position_m: [Some(read_m), None, None, None],
                reference: [Some(reference_m), None, None],
                ..Reading::default()
            });
        }
        Recording {
            meta: Meta {
                geometry: Geometry {
                    pitch_m: PITCH_M,
                    ..Geometry::default()
                },
                electronics: Electronics {
                    position_noise_m: Some(NOISE_M),
                    ..Electronics::default()
                },
                ..Meta::default()
            },
            samples,
            warnings: Vec::new(),
        }
    }

    /// The delay and the lag's total of a recording, fitted.
    fn fitted(seed: u64, louder: f64) -> [Estimate; 2] {
        let prepared = prepare(&late(seed, louder)).unwrap();
        let point = prepared.point();
        // The search is not what is tested here.
        let design_options = DesignOptions {
            only: Some(&[]),
            ..DesignOptions::default()
        };
        let first = assemble(&prepared, &Options::default(), &point, design_options);
        let relinearized = RelinearizedFit::new(&first.linearized, point, &["velocity_lag".into()]);
        let known = Posterior::of(&relinearized, birge_ratio(relinearized.residuals())).unwrap();
        let column = relinearized.columns.blocks[1].columns.start;
        let delay = Estimate {
            value: relinearized.coefficient(column),
            deviation: known.deviation(column),
        };
        [delay, known.total_m(1)]
    }

    /// Squares of errors over foretold variances, added up.
    fn chi_square(all: &[Estimate], truth: f64) -> f64 {
        let error = |known: &Estimate| (known.value - truth) / known.deviation;
        all.iter().map(|known| error(known).powi(2)).sum()
    }

    /// Over repeated recordings the delay scatters about the true one by its deviation, and the total about its mean. So they do where
    /// the noise is three times the stated one.
    #[test]
    fn deviations_are_those_of_repeated_recordings() {
        let speeds: Vec<f64> = (0..TOTAL_SAMPLES).map(speed_m_s).collect();
        let lag_m = LATE_S * crate::algebra::statistics::deviation(&speeds);
        for louder in [1.0, 3.0] {
            let all: Vec<[Estimate; 2]> = (0..SEEDS).map(|seed| fitted(seed, louder)).collect();
            let [delay, total] =
                [0, 1].map(|which| all.iter().map(|k| k[which]).collect::<Vec<_>>());
            // A segment that is late lacks speed times delay: so much is added.
            let sum = chi_square(&delay, LATE_S);
            let [least, most] = BY_CHANCE;
            assert!(
                (least..most).contains(&sum),
                "delay: {sum}, noise times {louder}"
            );
            // The ends of each run have no speed and do not count, which the motion's rms does not know.
            let mean_m = total.iter().map(|known| known.value).sum::<f64>() / SEEDS as f64;
            assert!((mean_m / lag_m - 1.0).abs() < 0.05, "{mean_m} of {lag_m}");
            let sum = chi_square(&total, mean_m);
            let [least, most] = ABOUT_THE_MEAN;
            assert!(
                (least..most).contains(&sum),
                "total: {sum}, noise times {louder}"
            );
        }
    }
}
