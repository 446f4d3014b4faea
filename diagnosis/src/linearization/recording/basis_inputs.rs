//! What a recording offers: which effects its data can speak about.

use super::LinearizedRecording;
use crate::algebra::statistics::quantile;
use crate::data::observations::Observations;
use crate::data::one_way::is_one_way;
use effects::sensor::{BasisInputs, LoggedColumn, MOST_LOGGED};
use recording::Logged;

/// Standard deviation of the angle from which on a recording tells what depends on it. Derived from the span: a milliradian is
/// 9.7 µm between both segments; errors of equation (3) that g_p does not show (of both pairs alike, in a fly-by along one axis)
/// make up to half of this.
const TURNING_RAD: f64 = 1.0e-3;

/// Deviation over its mean from which on a logged column changes: below, it is rounded. Derived from the seven digits of an f32.
const CHANGES: f64 = 1.0e-6;

/// Quantiles between which nearly all samples lie: a slip turns what is read by a tooth. Derived from slips that last for less
/// than a two hundredth of the recording.
const MIDDLE_QUANTILES: [f64; 2] = [0.005, 0.995];

impl LinearizedRecording<'_> {
    fn middle_m(&self, samples: usize) -> [f64; 2] {
        [0, 1].map(|axis| {
            let all = (0..samples).map(|i| self.centre_m(i)[axis]);
            let (sum, count) = all
                .filter(|c| c.is_finite())
                .fold((0.0, 0), |(sum, count), c| (sum + c, count + 1));
            sum / f64::from(count.max(1))
        })
    }

    pub(super) fn look_over(&self, n: usize, temperatures: &[f64]) -> BasisInputs {
        let o = self.observations;
        let pairs = self.scope.segments.iter().all(|s| *s);
        let referenced = |axis: usize| !o.reference[axis].is_empty();
        let thetas: Vec<f64> = if pairs || referenced(2) {
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
        BasisInputs {
            segments: self.scope.segments,
            late_s: o
                .late
                .each_ref()
                .map(|late| late.as_ref().map_or(0.0, |late| late.delay_s)),
            reference: self.scope.reference,
            beacon: self.scope.beacon,
            counts: o.amplitude_counts.iter().any(|a| !a.is_empty()),
            temperature: temperatures.len() > n / 4
                && crate::algebra::statistics::spread(temperatures) > 0.05,
            turning: crate::algebra::statistics::deviation(&thetas) > TURNING_RAD,
            thetas_rad: MIDDLE_QUANTILES.map(|q| quantile(&mut thetas.clone(), q).unwrap_or(0.0)),
            moving: self
                .motion
                .direction
                .iter()
                .any(|d| d.iter().filter(|v| **v != 0.0).count() > 20),
            lateral: [0, 1].iter().all(|&axis| {
                self.scope.segments[axis] || self.scope.segments[axis + 2] || referenced(axis)
            }),
            top_speed_m_s: self.motion.top_speed_m_s,
            travel_m: std::array::from_fn(|s| {
                crate::algebra::statistics::spread(&self.calibrated_m[s])
            }),
            middle_m: self.middle_m(n),
            pitch_m: o.pitch_m,
            tan_full_scale: o.tan_full_scale,
            duration_s: o.t_s[n - 1] - o.t_s[0],
            warmths_k: crate::linearization::recording::range(temperatures)
                .map_or([0.0; 2], |r| r.map(|t| t - self.normal.temperature_c)),
            beacon_stretches,
            logged: logged(o),
            ..BasisInputs::default()
        }
    }
}

/// Logged columns that change.
fn logged(o: &Observations) -> Vec<LoggedColumn> {
    let column = |logged: &Logged| {
        let finite = logged.values.iter().copied().filter(|v| v.is_finite());
        let values: Vec<f64> = finite.collect();
        let column = LoggedColumn {
            name: logged.name.clone(),
            mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
            deviation: crate::algebra::statistics::deviation(&values),
            one_way: is_one_way(&values),
        };
        let changes = column.deviation > CHANGES * column.mean.abs().max(f64::MIN_POSITIVE);
        changes.then_some(column)
    };
    o.logged
        .iter()
        .filter_map(column)
        .take(MOST_LOGGED)
        .collect()
}
