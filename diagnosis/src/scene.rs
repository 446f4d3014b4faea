//! One recording under one baseline: residual channels, their noise, and what the sensor knows at each sample.

use crate::baseline::{Baseline, Scope};
use crate::motion::Motion;
use crate::observe::Observations;
use effects::sensor::{
    Action, CHANNELS, LATERAL_ORDERS, Moment, ORDERS, RAW_ORDERS, READINGS, Regressor, Survey,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Most rows that a sample gives: g_p, g_x, g_y, or four segments against a reference.
pub const ROWS: usize = 4;

/// A recording, linearised about a baseline.
pub struct Scene<'a> {
    /// The recording.
    pub observations: &'a Observations,
    /// Parameters that it is linearised about.
    pub baseline: Baseline,
    /// What they can speak about.
    pub scope: Scope,
    /// Speeds and directions.
    pub motion: Motion,
    /// What the recording offers.
    pub survey: Survey,
    /// Calibrated segment positions, m.
    pub calibrated_m: [Vec<f64>; 4],
    /// Samples in use; disturbed ones are not.
    pub keep: Vec<bool>,
    /// What "no effect" means for amplitude and temperature: from this recording, or from the one that a model is of.
    pub normal: Normal,
    gain: [Vec<f64>; 4],
    ln_amplitude: [Vec<f64>; 4],
}

/// Reference values that amounts are relative to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Normal {
    /// Mean temperature, °C.
    pub temperature_c: f64,
    /// Logarithm of each pair's amplitude as mean, sines and cosines of orders 1 to 8 of the own phase; empty without counts.
    pub ln_amplitude: [Vec<f64>; 4],
}

/// The residual channels of one sample and how to whiten them.
#[derive(Clone, Copy, Debug)]
pub struct SampleRows {
    /// Rows in use.
    pub count: usize,
    /// Channel of each row.
    pub channel: [usize; ROWS],
    /// Residual of each row, m.
    pub residual_m: [f64; ROWS],
    /// Derivative of each row by the readings.
    pub by_reading: [[f64; READINGS]; ROWS],
    /// Lower triangle that makes the stated noise white with unit variance.
    pub whiten: [[f64; ROWS]; ROWS],
}

impl SampleRows {
    /// Whitens a vector over the rows.
    pub fn whitened(&self, value: &[f64; ROWS]) -> [f64; ROWS] {
        let mut out = [0.0; ROWS];
        for row in 0..self.count {
            out[row] = (0..=row).map(|k| self.whiten[row][k] * value[k]).sum();
        }
        out
    }

    /// What a unit amount of a regressor adds to the rows, m.
    pub fn response(&self, regressor: &Regressor, moment: &Moment) -> [f64; ROWS] {
        let mut out = [0.0; ROWS];
        match &regressor.action {
            Action::Readings(add) => {
                let mut readings = [0.0; READINGS];
                add(moment, &mut readings);
                for row in 0..self.count {
                    out[row] = self.by_reading[row]
                        .iter()
                        .zip(&readings)
                        .map(|(j, d)| j * d)
                        .sum();
                }
            }
            Action::Channels(add) => {
                let mut channels = [0.0; CHANNELS];
                add(moment, &mut channels);
                for row in 0..self.count {
                    out[row] = channels[self.channel[row]];
                }
            }
        }
        out
    }
}

impl<'a> Scene<'a> {
    /// Linearises a recording about a baseline.
    pub fn new(observations: &'a Observations, baseline: Baseline, keep: Vec<bool>) -> Self {
        Self::relative_to(observations, baseline, keep, None)
    }

    /// The same with amounts relative to another recording's normal values.
    pub fn relative_to(
        observations: &'a Observations,
        baseline: Baseline,
        keep: Vec<bool>,
        normal: Option<&Normal>,
    ) -> Self {
        let n = observations.len();
        let scope = scope(observations);
        let mut calibrated_m: [Vec<f64>; 4] = Default::default();
        let mut gain: [Vec<f64>; 4] = Default::default();
        for segment in (0..4).filter(|s| scope.segments[*s]) {
            (calibrated_m[segment], gain[segment]) = observations.position_m[segment]
                .iter()
                .map(|&p| baseline.calibrated(segment, p, observations.pitch_m))
                .unzip();
        }
        let motion = if scope.reference {
            let reference = std::array::from_fn(|s| {
                if scope.segments[s] {
                    (0..n).map(|i| observations.reference_m(s, i)).collect()
                } else {
                    Vec::new()
                }
            });
            Motion::new(observations, &reference)
        } else {
            Motion::new(observations, &calibrated_m)
        };
        let known: Vec<f64> = observations
            .temperature_c
            .iter()
            .copied()
            .filter(|t| t.is_finite())
            .collect();
        let mean_temperature_c = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let mut this = Self {
            observations,
            baseline,
            scope,
            motion,
            survey: Survey::default(),
            calibrated_m,
            keep,
            gain,
            ln_amplitude: Default::default(),
            normal: normal.cloned().unwrap_or(Normal {
                temperature_c: mean_temperature_c,
                ..Normal::default()
            }),
        };
        for segment in 0..4 {
            if this.normal.ln_amplitude[segment].is_empty() {
                this.normal.ln_amplitude[segment] = this.amplitude_pattern(segment);
            }
            this.ln_amplitude[segment] = this.amplitude_excess(segment);
        }
        this.survey = this.look_over(n, &known);
        this
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.observations.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.observations.is_empty()
    }

    fn look_over(&self, n: usize, temperatures: &[f64]) -> Survey {
        let o = self.observations;
        let spread = |values: &[f64]| {
            let (low, high) = values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(*v), h.max(*v))
                });
            high - low
        };
        let pairs = self.scope.segments.iter().all(|s| *s);
        let thetas: Vec<f64> = if pairs {
            (0..n)
                .map(|i| self.theta_rad(i))
                .filter(|t| t.is_finite())
                .collect()
        } else {
            Vec::new()
        };
        let mut beacon_stretches: Vec<usize> = (0..n)
            .filter(|&i| self.scope.beacon && o.sees_beacon(i))
            .map(|i| o.stretch[i])
            .collect();
        beacon_stretches.dedup();
        Survey {
            segments: self.scope.segments,
            beacon: self.scope.beacon,
            counts: o.amplitude_counts.iter().any(|a| !a.is_empty()),
            temperature: temperatures.len() > n / 4 && spread(temperatures) > 0.05,
            turning: !thetas.is_empty() && spread(&thetas) > 0.5e-3,
            moving: self
                .motion
                .direction
                .iter()
                .any(|d| d.iter().filter(|v| **v != 0.0).count() > 20),
            lateral: (self.scope.segments[0] || self.scope.segments[2])
                && (self.scope.segments[1] || self.scope.segments[3]),
            top_speed_m_s: self.motion.top_speed_m_s,
            travel_m: std::array::from_fn(|s| {
                let known: Vec<f64> = self.calibrated_m[s]
                    .iter()
                    .copied()
                    .filter(|p| p.is_finite())
                    .collect();
                if known.is_empty() {
                    0.0
                } else {
                    spread(&known)
                }
            }),
            pitch_m: o.pitch_m,
            tan_full_scale: o.tan_full_scale,
            duration_s: o.t_s[n - 1] - o.t_s[0],
            beacon_stretches,
            ..Survey::default()
        }
    }

    /// Angle of the courier from the four segments, rad (zero where it cannot be had).
    pub fn theta_rad(&self, i: usize) -> f64 {
        let p = |s: usize| self.calibrated_m[s].get(i).copied();
        match (p(0), p(1), p(2), p(3)) {
            (Some(a), Some(b), Some(c), Some(d)) => {
                (a - c + b - d - self.angle_offset_m()) / (2.0 * self.observations.span_m)
            }
            (Some(a), _, Some(c), _) => (a - c) / self.observations.span_m,
            (_, Some(b), _, Some(d)) => (b - d) / self.observations.span_m,
            _ => self.observations.reference[2]
                .get(i)
                .copied()
                .filter(|t| t.is_finite())
                .unwrap_or(0.0),
        }
    }

    /// The tooth counts' arbitrary zeros enter the angle as well: half of g_p's offset belongs to each pair.
    fn angle_offset_m(&self) -> f64 {
        0.0
    }

    fn centre_m(&self, i: usize) -> [f64; 2] {
        [0, 1].map(|axis| {
            let values: Vec<f64> = [axis, axis + 2]
                .iter()
                .filter_map(|&s| self.calibrated_m[s].get(i).copied())
                .collect();
            if values.is_empty() {
                0.0
            } else {
                values.iter().sum::<f64>() / values.len() as f64
            }
        })
    }

    /// Rows of a sample; none where a reading is missing.
    pub fn rows(&self, i: usize) -> SampleRows {
        let mut rows = SampleRows {
            count: 0,
            channel: [0; ROWS],
            residual_m: [0.0; ROWS],
            by_reading: [[0.0; READINGS]; ROWS],
            whiten: [[0.0; ROWS]; ROWS],
        };
        if self.scope.reference {
            self.reference_rows(i, &mut rows);
        } else {
            self.constraint_rows(i, &mut rows);
        }
        self.fill_whitener(i, &mut rows);
        rows
    }

    fn reference_rows(&self, i: usize, rows: &mut SampleRows) {
        for segment in (0..4).filter(|s| self.scope.segments[*s]) {
            let residual =
                self.calibrated_m[segment][i] - self.observations.reference_m(segment, i);
            if residual.is_finite() {
                rows.channel[rows.count] = 3 + segment;
                rows.residual_m[rows.count] = residual;
                rows.by_reading[rows.count][segment] = 1.0;
                rows.count += 1;
            }
        }
    }

    fn constraint_rows(&self, i: usize, rows: &mut SampleRows) {
        if !(0..4).all(|s| self.calibrated_m[s].get(i).is_some_and(|p| p.is_finite())) {
            return;
        }
        let p: [f64; 4] = std::array::from_fn(|s| self.calibrated_m[s][i]);
        rows.count = 1;
        rows.residual_m[0] = (p[0] - p[2]) - (p[1] - p[3]) + self.baseline.parity_offset_m;
        rows.by_reading[0] = [1.0, -1.0, -1.0, 1.0, 0.0, 0.0];
        if !self.scope.beacon || !self.observations.sees_beacon(i) {
            return;
        }
        let theta = self.theta_rad(i);
        let tan = [0, 1].map(|axis| self.observations.tan_psi[axis][i]);
        let (g, by_theta) = self.baseline.beacon_residual(self.centre_m(i), theta, tan);
        let (sine, cosine) = theta.sin_cos();
        let h = self.baseline.height_m;
        let turn = 0.5 / self.observations.span_m;
        for axis in 0..2 {
            let row = 1 + axis;
            rows.channel[row] = row;
            rows.residual_m[row] = g[axis];
            let d = by_theta[axis] * turn;
            rows.by_reading[row][..4].copy_from_slice(&[d, d, -d, -d]);
            rows.by_reading[row][axis] -= 0.5;
            rows.by_reading[row][axis + 2] -= 0.5;
        }
        rows.by_reading[1][4..].copy_from_slice(&[h * cosine, -h * sine]);
        rows.by_reading[2][4..].copy_from_slice(&[h * sine, h * cosine]);
        rows.count = 3;
    }

    /// Inverse Cholesky factor of the rows' covariance.
    fn fill_whitener(&self, i: usize, rows: &mut SampleRows) {
        let variance = self.reading_variance(i);
        let m = rows.count;
        let mut lower = [[0.0; ROWS]; ROWS];
        for a in 0..m {
            for b in 0..=a {
                let covariance: f64 = (0..READINGS)
                    .map(|r| rows.by_reading[a][r] * variance[r] * rows.by_reading[b][r])
                    .sum();
                let known: f64 = (0..b).map(|k| lower[a][k] * lower[b][k]).sum();
                let rest: f64 = covariance - known;
                lower[a][b] = if a == b {
                    rest.max(1e-24).sqrt()
                } else {
                    rest / lower[b][b]
                };
            }
        }
        for column in 0..m {
            for row in column..m {
                let unit = if row == column { 1.0 } else { 0.0 };
                let known: f64 = (column..row)
                    .map(|k| lower[row][k] * rows.whiten[k][column])
                    .sum();
                rows.whiten[row][column] = (unit - known) / lower[row][row];
            }
        }
    }

    /// Variance of the calibrated readings by the stated noise.
    pub fn reading_variance(&self, i: usize) -> [f64; READINGS] {
        std::array::from_fn(|r| {
            if r < 4 {
                let noise = self.observations.position_noise_m[r]
                    .get(i)
                    .copied()
                    .unwrap_or(0.0);
                let gain = self.gain[r].get(i).copied().unwrap_or(1.0);
                (noise * gain).powi(2)
            } else {
                let noise = self.observations.tan_psi_noise[r - 4]
                    .get(i)
                    .copied()
                    .unwrap_or(0.0);
                if noise.is_finite() {
                    noise * noise
                } else {
                    0.0
                }
            }
        })
    }

    /// What the sensor knows at a sample.
    pub fn moment(&self, i: usize) -> Moment {
        let o = self.observations;
        let f = TAU / o.pitch_m;
        let theta = self.theta_rad(i);
        let theta = if theta.is_finite() { theta } else { 0.0 };
        let centre = self.centre_m(i);
        let own_m: [f64; 4] = std::array::from_fn(|s| finite(self.calibrated_m[s].get(i)));
        let lateral_sign = [-1.0, 1.0, 1.0, -1.0];
        let across_m: [f64; 4] = std::array::from_fn(|s| {
            finite(Some(&centre[1 - s % 2])) + lateral_sign[s] * o.lateral_m * theta
        });
        let shift = [-0.5, 0.5, 0.5, -0.5];
        let at = |list: &[Vec<f64>; 4]| std::array::from_fn(|s| finite(list[s].get(i)));
        let tan_psi = [0, 1].map(|axis: usize| finite(o.tan_psi[axis].get(i)));
        let start = o.t_s[0];
        Moment {
            progress: (o.t_s[i] - start) / self.survey.duration_s.max(1e-12),
            t_s: o.t_s[i] - start,
            stretch: o.stretch[i],
            raw_phase: std::array::from_fn(|s| f * finite(o.position_m[s].get(i))),
            reference_phase: std::array::from_fn(|s| f * finite(Some(&o.reference_m(s, i)))),
            raw: std::array::from_fn(|s| {
                multiples::<{ RAW_ORDERS + 1 }>(f * finite(o.position_m[s].get(i)))
            }),
            own: std::array::from_fn(|s| multiples::<{ ORDERS + 1 }>(f * own_m[s])),
            lateral: std::array::from_fn(|s| multiples::<{ LATERAL_ORDERS + 1 }>(f * across_m[s])),
            place_m: std::array::from_fn(|s| [own_m[s], across_m[s] + shift[s] * o.span_m]),
            centre_m: [0, 1].map(|axis| finite(Some(&centre[axis]))),
            theta_rad: theta,
            speed_m_s: at(&self.motion.speed_m_s),
            acceleration_m_s2: at(&self.motion.acceleration_m_s2),
            direction: at(&self.motion.direction),
            approach: at(&self.motion.approach),
            tan_psi,
            tan_psi_rate: [0, 1].map(|axis: usize| finite(self.motion.tan_psi_rate[axis].get(i))),
            deflection: tan_psi.map(|t| {
                if o.tan_full_scale > 0.0 {
                    t / o.tan_full_scale
                } else {
                    0.0
                }
            }),
            warmth_k: o
                .temperature_c
                .get(i)
                .filter(|t| t.is_finite())
                .map_or(0.0, |t| t - self.normal.temperature_c),
            ln_amplitude: at(&self.ln_amplitude),
        }
    }

    /// Logarithm of the amplitude and its regressors: mean and own-phase orders up to eight.
    fn amplitude_row(
        &self,
        segment: usize,
        i: usize,
    ) -> Option<(nalgebra::SVector<f64, PATTERN>, f64)> {
        let value = self.observations.amplitude_counts[segment][i].ln();
        let phase = TAU / self.observations.pitch_m * self.calibrated_m[segment][i];
        (value.is_finite() && phase.is_finite()).then(|| {
            let table = multiples::<9>(phase);
            let entry = |j: usize| {
                if j % 2 == 1 {
                    table[j.div_ceil(2)].0
                } else {
                    table[j / 2].1
                }
            };
            (nalgebra::SVector::from_fn(|j, _| entry(j)), value)
        })
    }

    fn amplitude_pattern(&self, segment: usize) -> Vec<f64> {
        let n = self.observations.amplitude_counts[segment].len();
        let mut normal = nalgebra::SMatrix::<f64, PATTERN, PATTERN>::identity() * 1e-9;
        let mut right = nalgebra::SVector::<f64, PATTERN>::zeros();
        for (x, y) in (0..n).filter_map(|i| self.amplitude_row(segment, i)) {
            normal += x * x.transpose();
            right += x * y;
        }
        normal
            .cholesky()
            .filter(|_| n > 0)
            .map_or(Vec::new(), |factor| {
                factor.solve(&right).iter().copied().collect()
            })
    }

    fn amplitude_excess(&self, segment: usize) -> Vec<f64> {
        let pattern = &self.normal.ln_amplitude[segment];
        if pattern.len() != PATTERN {
            return Vec::new();
        }
        let c = nalgebra::SVector::<f64, PATTERN>::from_column_slice(pattern);
        let n = self.observations.amplitude_counts[segment].len();
        (0..n)
            .map(|i| {
                self.amplitude_row(segment, i)
                    .map_or(0.0, |(x, y)| y - c.dot(&x))
            })
            .collect()
    }
}

/// Regressors of an amplitude's pattern.
const PATTERN: usize = 17;

fn finite(value: Option<&f64>) -> f64 {
    value.copied().filter(|v| v.is_finite()).unwrap_or(0.0)
}

/// `(sin, cos)` of 0, 1, 2, ... times a phase by the angle-sum rule.
fn multiples<const N: usize>(phase: f64) -> [(f64, f64); N] {
    let (s, c) = phase.sin_cos();
    let mut table = [(0.0, 1.0); N];
    for n in 1..N {
        let (ps, pc) = table[n - 1];
        table[n] = (ps * c + pc * s, pc * c - ps * s);
    }
    table
}

/// What the residuals can be formed of.
pub fn scope(o: &Observations) -> Scope {
    let segments: [bool; 4] = std::array::from_fn(|s| o.has_segment(s));
    let all = segments.iter().all(|s| *s);
    let beacon = all && !o.tan_psi[0].is_empty();
    let referenced =
        |s: usize| segments[s] && (0..o.len()).any(|i| o.reference_m(s, i).is_finite());
    let turning_known =
        !o.reference[2].is_empty() || !(segments[0] && segments[2] || segments[1] && segments[3]);
    let reference = !beacon && turning_known && (0..4).any(referenced);
    let in_use = if reference {
        std::array::from_fn(referenced)
    } else {
        segments
    };
    let complete = reference && all && in_use.iter().all(|s| *s);
    Scope {
        segments: in_use,
        beacon,
        reference: reference && (complete || !all),
    }
}
