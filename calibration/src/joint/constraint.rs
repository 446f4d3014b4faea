//! The three constraints g_p, g_x, g_y of one pose (equations 5, 10, 11), their Jacobian and their covariance.
//!
//! With `b = o' + l` in place of o' (the beacon's place seen at angle zero) equation (11) reads
//!
//! ```text
//! g_x = -p_x + cos(t) c_x - sin(t) c_y - l_y sin(t) - l_x (1 - cos(t)) + b_x
//! g_y = -p_y + sin(t) c_x + cos(t) c_y + l_x sin(t) - l_y (1 - cos(t)) + b_y
//! ```
//!
//! and no two large numbers cancel. The noise of segments and deflections enters all three, and g_y through the lever
//! arm: the rows are whitened by its covariance. As the readings stand in the Jacobian too, that is taken at the readings'
//! own estimate (Gauss-Helmert model; Neitzel 2010, "Generalization of total least-squares"): at the noisy readings themselves
//! the lever arm would come out short by `l var(noise of t) / var(t)`, 4 um in the paper's synthetic problem.

mod jacobian;

use super::layout::{JOINT_UNKNOWNS, Layout, Values};
use super::sample::JointSample;
use super::whitening::{Whitening, small_angle};
use crate::diode::{self, DiodeErrors};
use crate::equations::{
    ANGLE_SIGN, Angle, LATERAL_SIGN, PARITY_SIGN, beacon, by_outputs, middle, parity, theta,
};
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::math::sqrt;
use crate::model::Basis;
use core::f32::consts::TAU;

/// Readings of a pose: four segments, two deflections.
const READINGS: usize = SEGMENTS + 2;

/// g_p, g_x, g_y, metres.
pub type Misclosure = [f32; 3];

/// Standard deviations of a pose's averaged readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingNoise {
    /// Of a segment, metres.
    pub segment_m: f32,
    /// Of the beacon's displacement, metres (its deflection times height times full scale).
    pub displacement_m: f32,
}

/// How the three constraints are weighted against each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weighting {
    /// By the covariance of the readings' noise.
    #[default]
    Covariance,
    /// All alike and independent, as in the paper's 3.2.1.
    Equal,
}

/// The constraints' fixed part.
#[derive(Clone, Debug)]
pub struct Constraints {
    /// Nominal geometry; height and lever arm are unknowns.
    pub geometry: Geometry,
    /// Order of the unknowns.
    pub layout: Layout,
    /// Noise that the weights follow.
    pub noise: ReadingNoise,
    /// Noise as stated: the least that is believed.
    pub stated_noise: ReadingNoise,
    /// How the constraints are weighted.
    pub weighting: Weighting,
}

/// One pose linearised: `jacobian * change = -misclosure`, whitened.
#[derive(Clone, Copy, Debug)]
pub struct Rows {
    /// Three rows over all unknowns of the layout.
    pub jacobian: [Values; 3],
    /// Of unit variance where the model holds.
    pub misclosure: Misclosure,
}

/// Everything about one pose at some values.
struct Instant {
    basis: Basis,
    misclosure: Misclosure,
    sine: f32,
    cosine: f32,
    deflection: [f32; 2],
    displacement_m: [f32; 2],
    /// Derivatives of g_x and g_y by the angle.
    by_angle: [f32; 2],
}

impl Constraints {
    /// Constraints of a pose, metres, not whitened: what the paper calls residuals.
    #[must_use]
    pub fn misclosure(&self, values: &Values, sample: &JointSample) -> Misclosure {
        self.at(values, sample).misclosure
    }

    /// The same, whitened by the covariance that other values give.
    #[must_use]
    pub fn whitened(
        &self,
        values: &Values,
        weights_from: &Values,
        sample: &JointSample,
    ) -> Misclosure {
        let instant = self.at(weights_from, sample);
        let by_readings = self.by_readings(weights_from, &instant);
        self.whitening(weights_from, &by_readings)
            .apply(self.misclosure(values, sample))
    }

    /// Share of the segments' variance in g_x at a pose: what is left of g_x's is the deflection's.
    #[must_use]
    pub(super) fn segment_share_of_x(&self, values: &Values, sample: &JointSample) -> f32 {
        let instant = self.at(values, sample);
        self.by_outputs(&instant)[1].iter().map(|b| b * b).sum()
    }

    /// Whitened rows for a Gauss-Newton step from some values.
    #[must_use]
    pub fn rows(&self, values: &Values, sample: &JointSample) -> Rows {
        let first = self.at(values, sample);
        let by_readings = self.by_readings(values, &first);
        let estimate = self.estimated(values, sample, &by_readings, first.misclosure);
        let instant = self.at(values, &estimate);
        let by_readings = self.by_readings(values, &instant);
        let whitening = self.whitening(values, &by_readings);
        // Gauss-Helmert: the misclosure at the estimate, carried back to the readings.
        let mut misclosure = instant.misclosure;
        let moved = self.moved(sample, &estimate);
        for (w, b) in misclosure.iter_mut().zip(&by_readings) {
            *w += b.iter().zip(moved).map(|(b, m)| b * m).sum::<f32>();
        }
        let mut rows = Rows {
            jacobian: [[0.0; JOINT_UNKNOWNS]; 3],
            misclosure: whitening.apply(misclosure),
        };
        self.fill_jacobian(values, &instant, &mut rows.jacobian);
        whitening.apply_rows(&mut rows.jacobian, self.layout.len());
        rows
    }

    fn at(&self, values: &Values, sample: &JointSample) -> Instant {
        let g = &self.geometry;
        let basis = Basis::new(g, &sample.observation());
        let p = self.calibrated_m(values, sample, &basis);
        let (sine, cosine_rest) = small_angle(theta(&p, g.span_m));
        let cosine = 1.0 - cosine_rest;
        let angle = Angle {
            sine,
            cosine,
            cosine_rest,
        };
        let displacement_m = self.displacement_m(values, sample);
        let lever_m = self.lever_m(values);
        let place = self.layout.place();
        let place_m = [values[place], values[place + 1]];
        let seen = beacon(middle(&p), displacement_m, lever_m, place_m, &angle);
        Instant {
            basis,
            misclosure: [parity(&p), seen.g[0], seen.g[1]],
            sine,
            cosine,
            deflection: sample.deflection,
            displacement_m,
            by_angle: seen.by_theta,
        }
    }

    fn lever_m(&self, values: &Values) -> [f32; 2] {
        let lever = self.layout.lever();
        [values[lever], values[lever + 1]]
    }

    /// Calibrated outputs from the origin, metres.
    fn calibrated_m(
        &self,
        values: &Values,
        sample: &JointSample,
        basis: &Basis,
    ) -> [f32; SEGMENTS] {
        let turns = sample.turns();
        let offsets = [
            values[self.layout.parity_offset()] / 4.0,
            values[self.layout.angle_offset()] / 4.0,
        ];
        core::array::from_fn(|i| {
            let functions = basis.segment(i, Layout::ORDERS.0, Layout::ORDERS.1);
            let coefficients = values[i * self.layout.columns()..].as_chunks::<2>().0;
            let mut error = PARITY_SIGN[i] * offsets[0] + ANGLE_SIGN[i] * offsets[1];
            for ((_, term), [a, b]) in self.layout.terms.iter().zip(coefficients) {
                let [sine, cosine] = functions.term(term);
                error += a * sine + b * cosine;
            }
            turns[i] * self.geometry.pitch_m + error
        })
    }

    /// Displacement of the beacon in the sensor's frame, equation (10).
    fn displacement_m(&self, values: &Values, sample: &JointSample) -> [f32; 2] {
        let layout = &self.layout;
        let mut errors: DiodeErrors = [0.0; _];
        errors.copy_from_slice(&values[layout.gain_difference()..layout.len()]);
        let scale = values[layout.height()] * self.geometry.tan_full_scale;
        diode::corrected(sample.deflection, &errors).map(|u| u * scale)
    }

    /// Derivatives of the constraints by the calibrated outputs.
    fn by_outputs(&self, instant: &Instant) -> [[f32; SEGMENTS]; 3] {
        by_outputs(instant.by_angle, self.geometry.span_m)
    }

    /// Derivatives of the constraints by the readings: unmodified outputs (metres) and deflections.
    fn by_readings(&self, values: &Values, instant: &Instant) -> [[f32; READINGS]; 3] {
        let by_outputs = self.by_outputs(instant);
        let slopes = self.slopes(values, &instant.basis);
        let scale = values[self.layout.height()] * self.geometry.tan_full_scale;
        let (s, c) = (instant.sine * scale, instant.cosine * scale);
        let by_deflection = [[0.0, 0.0], [c, -s], [s, c]];
        core::array::from_fn(|row| {
            core::array::from_fn(|reading| match reading {
                0..SEGMENTS => (0..SEGMENTS)
                    .map(|i| by_outputs[row][i] * slopes[i][reading])
                    .sum(),
                _ => by_deflection[row][reading - SEGMENTS],
            })
        })
    }

    /// Derivatives of the calibrated outputs by the unmodified ones, `[calibrated][unmodified]`.
    fn slopes(&self, values: &Values, basis: &Basis) -> [[f32; SEGMENTS]; SEGMENTS] {
        let g = &self.geometry;
        let per_metre = TAU / g.pitch_m;
        core::array::from_fn(|i| {
            let functions = basis.segment(i, Layout::ORDERS.0, Layout::ORDERS.1);
            let coefficients = values[i * self.layout.columns()..].as_chunks::<2>().0;
            let (mut own, mut across) = (0.0, 0.0);
            for ((_, term), [a, b]) in self.layout.terms.iter().zip(coefficients) {
                let [sine, cosine] = functions.term(term);
                let slope = (a * cosine - b * sine) * per_metre;
                own += slope * f32::from(term.own_order);
                across += slope * f32::from(term.lateral_order);
            }
            core::array::from_fn(|j| {
                let other_pair = if (i + j) % 2 == 1 { 0.5 } else { 0.0 };
                let turn = LATERAL_SIGN[i] * ANGLE_SIGN[j] * g.lateral_m / (2.0 * g.span_m);
                let itself = if i == j { 1.0 + own } else { 0.0 };
                itself + across * (other_pair + turn)
            })
        })
    }

    fn variances(&self, values: &Values) -> [f32; READINGS] {
        let scale = values[self.layout.height()] * self.geometry.tan_full_scale;
        let deflection = self.noise.displacement_m / scale;
        core::array::from_fn(|i| {
            let deviation = if i < SEGMENTS {
                self.noise.segment_m
            } else {
                deflection
            };
            deviation * deviation
        })
    }

    fn whitening(&self, values: &Values, by_readings: &[[f32; READINGS]; 3]) -> Whitening {
        if self.weighting == Weighting::Equal {
            let variance = 4.0 * self.noise.segment_m * self.noise.segment_m;
            return Whitening::of([
                [variance, 0.0, 0.0],
                [0.0, variance, 0.0],
                [0.0, 0.0, variance],
            ]);
        }
        let variances = self.variances(values);
        Whitening::of(core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                (0..READINGS)
                    .map(|k| by_readings[i][k] * variances[k] * by_readings[j][k])
                    .sum()
            })
        }))
    }

    /// Most likely readings, given that the constraints hold at these values.
    fn estimated(
        &self,
        values: &Values,
        sample: &JointSample,
        by_readings: &[[f32; READINGS]; 3],
        misclosure: Misclosure,
    ) -> JointSample {
        let weighted = self.whitening(values, by_readings).solve(misclosure);
        let variances = self.variances(values);
        let mut estimate = *sample;
        if self.weighting == Weighting::Equal {
            return estimate;
        }
        for reading in 0..READINGS {
            let pull: f32 = (0..3)
                .map(|row| by_readings[row][reading] * weighted[row])
                .sum();
            // Far-off poses (an early iteration, an outlier) are not drawn to where the linearisation has no meaning.
            let deviations = 4.0 * sqrt(variances[reading]);
            // Not `clamp`: the text of its panic would bring 14 KiB of float formatting into the image.
            let change = bounded(variances[reading] * pull, deviations);
            match reading {
                0..SEGMENTS => estimate.fraction_turns[reading] -= change / self.geometry.pitch_m,
                _ => estimate.deflection[reading - SEGMENTS] -= change,
            }
        }
        estimate
    }

    /// Readings minus estimate: metres, deflections.
    fn moved(&self, sample: &JointSample, estimate: &JointSample) -> [f32; READINGS] {
        core::array::from_fn(|i| match i {
            0..SEGMENTS => {
                (sample.fraction_turns[i] - estimate.fraction_turns[i]) * self.geometry.pitch_m
            }
            _ => sample.deflection[i - SEGMENTS] - estimate.deflection[i - SEGMENTS],
        })
    }
}

/// `x`, at most `limit` either way; NaN stays.
fn bounded(x: f32, limit: f32) -> f32 {
    if x > limit {
        limit
    } else if x < -limit {
        -limit
    } else {
        x
    }
}
