//! What the sensor knows at a sample, from calibrated readings.

use super::LinearizedRecording;
use courier_signal::equations::{ANGLE_SIGN, lateral_arguments, places, theta};
use effects::sensor::{Covariates, LATERAL_ORDERS, LoggedColumn, ORDERS};
use std::f64::consts::TAU;

/// What a step of one segment's raw reading changes.
#[derive(Clone, Copy)]
struct Step {
    segment: usize,
    /// Of the reading, m.
    raw_m: f64,
    /// Of the segment's place, m.
    place_m: f64,
    /// Calibration's gain there.
    gain: f64,
}

impl LinearizedRecording<'_> {
    /// Angle of the courier from the segments, rad (the reference's, or zero, where it cannot be had).
    pub fn theta_rad(&self, i: usize) -> f64 {
        self.theta_of(i, |s| self.calibrated_m[s].get(i).copied())
    }

    fn theta_of(&self, i: usize, p: impl Fn(usize) -> Option<f64>) -> f64 {
        match (p(0), p(1), p(2), p(3)) {
            (Some(a), Some(b), Some(c), Some(d)) => theta(&[a, b, c, d], self.observations.span_m),
            (Some(a), _, Some(c), _) => (a - c) / self.observations.span_m,
            (_, Some(b), _, Some(d)) => (b - d) / self.observations.span_m,
            _ => self.observations.reference[2]
                .get(i)
                .copied()
                .filter(|t| t.is_finite())
                .unwrap_or(0.0),
        }
    }

    /// The mean of a pair where there are two; where there is one, what it says less what half a span makes of the angle; else the reference.
    fn centre_of(&self, i: usize, p: impl Fn(usize) -> Option<f64>) -> [f64; 2] {
        let turn_m = 0.5 * self.observations.span_m * finite(Some(&self.theta_of(i, &p)));
        let by_one =
            |segment: usize, place_m: f64| place_m - f64::from(ANGLE_SIGN[segment]) * turn_m;
        [0, 1].map(|axis| match (p(axis), p(axis + 2)) {
            (Some(a), Some(b)) => 0.5 * (a + b),
            (Some(one), None) => by_one(axis, one),
            (None, Some(one)) => by_one(axis + 2, one),
            (None, None) => finite(self.observations.reference[axis].get(i)),
        })
    }

    /// Centre of the sensor, m.
    pub fn centre_m(&self, i: usize) -> [f64; 2] {
        self.centre_of(i, |s| self.calibrated_m[s].get(i).copied())
    }

    /// Calibrated position with what is known of the effects taken out, m: where a segment really is over its teeth.
    fn refined_m(&self, segment: usize, i: usize) -> Option<f64> {
        let at = |list: &[Vec<f64>; 4]| list[segment].get(i).copied().unwrap_or(0.0);
        let displacement = at(&self.displacement.total_m) + at(&self.quiet_m);
        self.calibrated_m[segment].get(i).map(|p| p + displacement)
    }

    /// The angle with what is known of the effects taken out, rad: not finite where it is not known.
    pub(super) fn refined_theta_rad(&self, i: usize) -> f64 {
        self.theta_of(i, |s| self.refined_m(s, i))
    }

    /// Centre of the sensor with what is known of the effects taken out, m; zero where it is not known.
    pub fn refined_centre_m(&self, i: usize) -> [f64; 2] {
        self.centre_of(i, |s| self.refined_m(s, i))
            .map(|centre| finite(Some(&centre)))
    }

    /// A logged column less its mean and over its deviation, as the inputs tell them; zero where it was not measured.
    fn logged(&self, k: usize, i: usize) -> f64 {
        let value = |column: &LoggedColumn| {
            let mut all = self.observations.logged.iter();
            let found = all.find(|logged| logged.name == column.name)?;
            let value = found.values.get(i).filter(|v| v.is_finite())?;
            Some((value - column.mean) / column.deviation)
        };
        self.inputs.logged.get(k).and_then(value).unwrap_or(0.0)
    }

    /// What the sensor knows at a sample.
    pub fn covariates(&self, i: usize) -> Covariates {
        self.covariates_of(i, None)
    }

    /// The same if one segment's raw reading of this sample alone were a step further. Where the segment's place is that of its neighbours,
    /// the place stays, and so does the angle as the neighbours tell it.
    pub fn covariates_at_step(&self, i: usize, segment: usize, step_m: f64) -> Covariates {
        let o = self.observations;
        let off = finite(self.displacement.electronic_m[segment].get(i));
        let clean_m = finite(o.position_m[segment].get(i)) + off + step_m;
        let (error_m, slope) = self.baseline.error_m(segment, clean_m, o.pitch_m);
        let place_m = if self.is_quiet(segment, i) {
            0.0
        } else {
            let before_m = finite(self.calibrated_m[segment].get(i));
            clean_m - off + error_m - before_m
        };
        let step = Step {
            segment,
            raw_m: step_m,
            place_m,
            gain: 1.0 + slope,
        };
        self.covariates_of(i, Some(step))
    }

    fn covariates_of(&self, i: usize, step: Option<Step>) -> Covariates {
        let o = self.observations;
        let f = TAU / o.pitch_m;
        let stepped = |s: usize| step.filter(|step| step.segment == s);
        let refined_m = |s: usize| {
            let place_m = self.refined_m(s, i)?;
            Some(place_m + stepped(s).map_or(0.0, |step| step.place_m))
        };
        let theta = self.theta_of(i, refined_m);
        let theta = if theta.is_finite() { theta } else { 0.0 };
        let centre = self.centre_of(i, refined_m);
        let own_m: [f64; 4] = std::array::from_fn(|s| finite(refined_m(s).as_ref()));
        let across_m = lateral_arguments(centre.map(|c| finite(Some(&c))), theta, o.lateral_m);
        let at = |list: &[Vec<f64>; 4]| std::array::from_fn(|s| finite(list[s].get(i)));
        let tan_psi = [0, 1].map(|axis: usize| finite(o.tan_psi[axis].get(i)));
        let start = o.t_s[0];
        Covariates {
            progress: (o.t_s[i] - start) / self.inputs.duration_s.max(1e-12),
            t_s: o.t_s[i] - start,
            stretch: o.stretch[i],
            raw_phase: std::array::from_fn(|s| f * finite(o.position_m[s].get(i))),
            reference_phase: std::array::from_fn(|s| f * finite(Some(&o.reference_m(s, i)))),
            calibration_gain: std::array::from_fn(|s| {
                let gain = self.gain[s].get(i).copied().unwrap_or(1.0);
                stepped(s).map_or(gain, |step| step.gain)
            }),
            raw: of_segments::<{ ORDERS + 1 }>(|s| {
                let off = finite(self.displacement.electronic_m[s].get(i));
                let step_m = stepped(s).map_or(0.0, |step| step.raw_m);
                f * (finite(o.position_m[s].get(i)) + off + step_m)
            }),
            own: of_segments::<{ ORDERS + 1 }>(|s| f * own_m[s]),
            lateral: of_segments::<{ LATERAL_ORDERS + 1 }>(|s| f * across_m[s]),
            place_m: places(&own_m, &across_m, o.span_m),
            centre_m: [0, 1].map(|axis| finite(Some(&centre[axis]))),
            from_middle_m: [0, 1]
                .map(|axis| finite(Some(&centre[axis])) - self.inputs.middle_m[axis]),
            theta_rad: theta,
            steady_theta_rad: self
                .steady
                .theta_rad
                .get(i)
                .map_or(theta, |t| finite(Some(t))),
            steady_tan_psi: [0, 1].map(|axis: usize| {
                let estimate = self.steady.tan_psi[axis].get(i);
                estimate.map_or(tan_psi[axis], |t| finite(Some(t)))
            }),
            commanded_theta_rad: finite(o.commanded[2].get(i)),
            speed_m_s: at(&self.motion.speed_m_s),
            speed_ahead_m_s: std::array::from_fn(|s| match &o.late[s] {
                Some(late) => finite(late.ahead_m.get(i)) / late.delay_s,
                None => finite(self.motion.speed_m_s[s].get(i)),
            }),
            acceleration_m_s2: at(&self.motion.acceleration_m_s2),
            direction: at(&self.motion.direction),
            approach: at(&self.motion.approach),
            memory: std::array::from_fn(|s| {
                self.motion.memory[s].get(i).copied().unwrap_or_default()
            }),
            before: at(&self.motion.before),
            underway: self.motion.underway.get(i).copied().unwrap_or_default(),
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
            behind_k: self.behind_k.get(i).copied().unwrap_or_default(),
            ln_amplitude: at(self
                .amplitudes
                .by_place
                .as_ref()
                .unwrap_or(&self.ln_amplitude)),
            amplitude_excess: at(&self.ln_amplitude),
            logged: std::array::from_fn(|k| self.logged(k, i)),
            pair_turn_rad: std::array::from_fn(|s| self.pair_turn_rad(s, i)),
            half_quadrature_angle_rad: std::array::from_fn(|s| {
                self.half_quadrature_angle_rad(s, i)
            }),
        }
    }
}

fn finite(value: Option<&f64>) -> f64 {
    value.copied().filter(|v| v.is_finite()).unwrap_or(0.0)
}

/// [`multiples`] of each segment's phase. Order by order, so that no segment waits for another's last product.
fn of_segments<const N: usize>(phase: impl Fn(usize) -> f64) -> [[(f64, f64); N]; 4] {
    let mut tables = [[(0.0, 1.0); N]; 4];
    let once: [(f64, f64); 4] = std::array::from_fn(|segment| phase(segment).sin_cos());
    for n in 1..N {
        for (table, once) in tables.iter_mut().zip(&once) {
            table[n] = sum_of_angles(table[n - 1], *once);
        }
    }
    tables
}

/// `(sin, cos)` of 0, 1, 2, ... times a phase by the angle-sum rule.
pub(super) fn multiples<const N: usize>(phase: f64) -> [(f64, f64); N] {
    let mut table = [(0.0, 1.0); N];
    let once = phase.sin_cos();
    for n in 1..N {
        table[n] = sum_of_angles(table[n - 1], once);
    }
    table
}

/// Sine and cosine of the sum of two angles that are told by theirs.
fn sum_of_angles((s, c): (f64, f64), (sine, cosine): (f64, f64)) -> (f64, f64) {
    (s * cosine + c * sine, c * cosine - s * sine)
}
