//! How well a fit knows its amounts, and how much each effect does altogether on the recording's motion.
//!
//! The deviations are those of the fit's posterior covariance: of the stated noise (or of the one that the readings showed), the
//! motion, and the prior sizes of the amounts. They leave out what the model itself lacks, noise that neighbouring samples have in
//! common, that the prior sizes were chosen from the same data, and that another effect might have been the cause.

use crate::acting::{Group, Sample, TOGETHER};
use crate::factor::Factor;
use crate::refine::Refined;
use effects::sensor::CHANNELS;
use nalgebra::DVector;

/// Most samples that a total is formed over: an rms of so many is known to one percent.
const SAMPLES: usize = 4000;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// The covariance of a fit's amounts, as the factor of its inverse.
pub struct Posterior<'f, 'a> {
    fine: &'f Refined<'a>,
    factor: Factor,
}

impl<'f, 'a> Posterior<'f, 'a> {
    /// Of a fit. Cost: a third of the cube of its columns. None where its normal equations cannot be solved.
    pub fn of(fine: &'f Refined<'a>) -> Option<Self> {
        let all: Vec<usize> = (0..fine.gram.width()).collect();
        let mut precision = fine.gram.training(None).lower(&all);
        // The priors: unit deviations in the scale of the columns.
        (0..all.len()).for_each(|a| precision[(a, a)] += 1.0);
        let factor = Factor::new(precision)?;
        Some(Self { fine, factor })
    }

    /// Standard deviation of an amount, in its own unit. Cost: the square of the columns.
    pub fn deviation(&self, column: usize) -> f64 {
        let gram = &self.fine.gram;
        let mut unit = DVector::zeros(gram.width());
        unit[column] = 1.0;
        self.factor.solve(&unit)[column].max(0.0).sqrt() * gram.scale[column]
    }

    /// What a block of columns adds to the channels that it acts in, m rms over the samples in use, each channel about its mean: a
    /// constant is the channel's own zero.
    pub fn total_m(&self, block: usize) -> Known {
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
            return Known {
                value: 0.0,
                deviation: 0.0,
            };
        }
        // How the total changes with each amount, to first order.
        let mut slope = DVector::zeros(self.fine.gram.width());
        for row in &inside {
            for (column, response) in &row.by_amount {
                slope[*column] += off(row) * response / (count * value);
            }
        }
        let variance = slope.dot(&self.factor.solve(&slope));
        Known {
            value,
            deviation: variance.max(0.0).sqrt(),
        }
    }

    /// What a block adds to each row of some samples, evenly spread.
    fn rows(&self, block: usize) -> Vec<Row> {
        let Refined {
            scene,
            columns,
            gram,
            amounts,
            ..
        } = self.fine;
        let kept: Vec<usize> = (0..scene.len()).filter(|&i| scene.keep[i]).collect();
        let every = kept.len().div_ceil(SAMPLES).max(1);
        let some: Vec<usize> = kept.into_iter().step_by(every).collect();
        let mut out = Vec::new();
        for part in some.chunks(TOGETHER) {
            let asked = columns.blocks[block].columns.clone();
            let group = Group::new(scene, &columns.regressors, asked, part.iter().copied());
            for Sample { rows, moment, .. } in &group.samples {
                let mut here: Vec<Row> = rows.channel[..rows.count]
                    .iter()
                    .map(|channel| Row::empty(*channel))
                    .collect();
                for &c in &group.acting {
                    let response = rows.response(&columns.regressors[c], moment);
                    for (row, response) in here.iter_mut().zip(response) {
                        if response != 0.0 {
                            let scaled = response * gram.scale[c];
                            row.value_m += scaled * amounts[c];
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
    use crate::prepare::prepare;
    use crate::study::{Look, Options, study};
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use recording::{Electronics, Geometry, Meta, Recording, Row as Reading, Samples};
    use std::f64::consts::TAU;

    const PITCH_M: f64 = 1.0e-3;
    const NOISE_M: f64 = 0.1e-6;
    const LATE_S: f64 = 50.0e-6;
    const SEEDS: u64 = 20;

    /// A segment beside a reference, to and fro, late by [`LATE_S`].
    fn late(seed: u64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut samples = Samples::default();
        for k in 0..1500 {
            let t_s = f64::from(k) * 2.0e-3;
            let reference_m = 5.0 * PITCH_M * (1.0 - (1.3 * t_s).cos());
            let speed_m_s = 6.5 * PITCH_M * (1.3 * t_s).sin();
            let error_m = 3.0e-6 * (TAU * reference_m / PITCH_M).sin();
            let read_m = reference_m + error_m - LATE_S * speed_m_s + NOISE_M * normal(&mut rng);
            samples.push(&Reading {
                t_s,
                run: if k < 750 { "there" } else { "back" },
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
    fn fitted(seed: u64) -> [Known; 2] {
        let prepared = prepare(&late(seed)).unwrap();
        let about = prepared.about();
        let first = study(&prepared, &Options::default(), &about, Look::default());
        let fine = Refined::new(&first.scene, about, &["velocity_lag".into()]);
        let known = Posterior::of(&fine).unwrap();
        let column = fine.columns.blocks[1].columns.start;
        let delay = Known {
            value: fine.amount(column),
            deviation: known.deviation(column),
        };
        [delay, known.total_m(1)]
    }

    /// Mean square of what was drawn again and again about its mean, over what was foretold: 1 but for the chance of so few draws.
    #[test]
    fn deviations_are_those_of_repeated_recordings() {
        let all: Vec<[Known; 2]> = (0..SEEDS).map(fitted).collect();
        let freedom = (SEEDS - 1) as f64;
        // Four standard deviations of a variance of so many draws.
        let chance = 4.0 * (2.0 / freedom).sqrt();
        for which in 0..2 {
            let values: Vec<f64> = all.iter().map(|known| known[which].value).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let drawn = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / freedom;
            let foretold: f64 = all.iter().map(|known| known[which].deviation.powi(2)).sum();
            let ratio = drawn / (foretold / SEEDS as f64);
            println!("{which}: {mean:.4e}, drawn over foretold variance {ratio:.2}");
            assert!((ratio - 1.0).abs() < chance, "{which}: {ratio}");
        }
        // The speed's rms about its mean over the motion, times the delay.
        let [delay, total] = all[0];
        let speed_m_s = |k: u32| 6.5 * PITCH_M * (1.3 * 2.0e-3 * f64::from(k)).sin();
        let speeds: Vec<f64> = (0..1500).map(speed_m_s).collect();
        let lag_m = LATE_S * crate::statistics::deviation(&speeds);
        assert!((delay.value.abs() / LATE_S - 1.0).abs() < 0.1, "{delay:?}");
        assert!(
            (total.value / lag_m - 1.0).abs() < 0.1,
            "{total:?}, {lag_m}"
        );
    }
}
