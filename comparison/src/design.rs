//! The covariance of a platen calibration by what its record keeps of it.
//!
//! The record has no covariance: 33 unknowns would take its room twice. It names the poses that were visited, and with the waves that it holds the
//! rows of equation (7) are those again ([`crate::visited`]); one of version 2 does not, and there the rows are expected ones
//! ([`crate::expected`]). The noise of a row is what the parity of held-out poses left.
//!
//! What is left in the parity is no noise that is another at each pose, but mostly displaced teeth, the same whenever the courier comes by.
//! Over whole waves a smooth field has no part of order n, but the poses end somewhere: its mean r(x) over the way across has, over a way
//! of L along, the mean product
//!
//! ```text
//! (r(0) - r(L)) U(0) / L,   U' = u less its mean,   by the first step of an integration by parts
//! ```
//! with a function u of the place. Both segments of a pair see it alike, so the fit puts most of it into their difference. No number
//! of poses makes it smaller, and at another place it is another one.

use crate::lateral::Lateral;
use crate::phases::sinc;
use crate::rows::fitted;
use crate::significance::own_share;
use crate::{expected, visited};
use courier_sensor::calibration::Plan;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Way of the poses in x and y, pitches, unless that was asked otherwise: a record of version 2 does not say. By definition that of
/// `Visits::paper` (paper, 3.1.2).
const TRAVEL_PITCHES: f64 = 10.0;
/// Half of a segment that averages six teeth, pitches: with weights `(1 - u^2)^2`. A prior: 1.9 µm of tooth variation under such
/// a segment leave the paper's 4.1 µm of parity (3.1.2).
const HALF_PITCHES: f64 = 3.0;
/// Steps of the midpoint rule over a segment or a way. Derived from its error, a thousandth of the integral at the most.
const STEPS: i32 = 200;
/// Constants of a self-calibration are equal but for their signs, to rounding of f32. Derived from seven digits, which sums of
/// some tens of terms make six and five.
const ROUNDING: f32 = 1.0e-5;

/// What a record tells of its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Orders fitted, equal for all segments.
    pub orders: Vec<u8>,
    /// Covariance of the coefficients, m^2: those of segment 1 first, of each order its sine and cosine.
    pub covariance: DMatrix<f64>,
    /// Correlation of a pair's coefficients of each order, of segments without waves and teeth.
    pub correlation: Vec<f64>,
    /// Standard deviation of the parity of one pose, metres.
    pub noise_m: f64,
    /// Degrees of freedom of the noise.
    pub freedom: f64,
    /// Share of the noise's square, for each direction, that is the fit's own error: [`own_share`].
    pub own: f64,
    /// What lateral terms make of it, where the poses are known.
    pub lateral: Option<Lateral>,
    /// Poses that were fitted.
    pub poses: u16,
    /// How they were chosen, if the record says.
    pub plan: Option<Plan>,
}

/// By a calibration's record.
///
/// # Errors
/// Why it cannot be told.
pub fn of(calibration: &Calibration) -> Result<Design, String> {
    let quality = &calibration.quality;
    let orders: Vec<u8> = calibration
        .model
        .terms
        .iter()
        .filter(|term| fitted(term))
        .map(|term| term.own_order)
        .collect();
    let unknowns = 2 * SEGMENTS * orders.len() + 1;
    if quality.poses == 0 || quality.unknowns == 0 {
        return Err("it was not made by a self-calibration".into());
    }
    if usize::from(quality.unknowns) != unknowns
        || quality.rank != quality.unknowns
        || !spread(calibration)
    {
        return Err(
            "its terms are not those that its self-calibration fitted: a model was loaded over it"
                .into(),
        );
    }
    let (poses, count) = (f64::from(quality.poses), unknowns as f64);
    let (left_m, worst_m) = (
        f64::from(quality.residual_after_m),
        f64::from(quality.predicted_worst_m),
    );
    // More rows than unknowns, by two: below that the expected covariance is infinite.
    if poses < count + 2.0 || !(left_m > 0.0) || !(worst_m > 0.0) {
        return Err(format!(
            "{} poses with {left_m:e} m left and {worst_m:e} m predicted tell no covariance",
            quality.poses
        ));
    }
    let rows = match &calibration.poses {
        Some(poses) => visited::rows(&orders, calibration, poses)
            .ok_or("the poses that it names determine no fit")?,
        None => expected::rows(&orders, calibration).ok_or(
            "its waves are larger than an error that can be undone: they tell no covariance",
        )?,
    };
    // A held-out parity has the fit's uncertainty beside its own noise.
    let noise_m = left_m / (1.0 + rows.leverage).sqrt();
    let of_noise = &rows.per_pose * (noise_m * noise_m * rows.share / poses);
    let Geometry {
        span_m, pitch_m, ..
    } = calibration.geometry;
    let way = calibration.poses.map_or(TRAVEL_PITCHES, |poses| {
        f64::from(poses.range.travel_m / pitch_m)
    });
    let step_m2 = 2.0 * noise_m * noise_m * ends(f64::from(span_m / pitch_m), way);
    let of_wave = step_m2 / (TAU * way).powi(2);
    let edge = rows.phases.at_edge(rows.difference_rad);
    let teeth = &rows.per_pose * edge * &rows.per_pose * of_wave;
    Ok(Design {
        covariance: symmetric(&(of_noise + teeth)),
        correlation: orders
            .iter()
            .map(|&order| sinc(f64::from(order) * rows.difference_rad))
            .collect(),
        noise_m,
        freedom: rows.freedom,
        own: own_share(rows.leverage, unknowns - 1),
        lateral: rows.lateral.map(|of| of.beside(noise_m)),
        poses: quality.poses,
        plan: calibration.poses.map(|poses| poses.plan),
        orders,
    })
}

/// Without what rounding makes unlike.
fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (matrix + matrix.transpose())
}

/// How two readings of a tooth field go together that are so many pitches apart along or across: the weights' autocorrelation.
fn alike(away_pitches: f64) -> f64 {
    let weight = |u: f64| (1.0 - u * u).max(0.0).powi(2);
    let away = away_pitches / HALF_PITCHES;
    let sum = |away: f64| integral([-1.0, 1.0], |u| weight(u) * weight(u + away));
    sum(away) / sum(0.0)
}

/// The same of two means over a way that are so many pitches apart.
fn means_alike(away_pitches: f64, way_pitches: f64) -> f64 {
    let each = |t: f64| (1.0 - t.abs() / way_pitches) * alike(away_pitches + t);
    integral([-way_pitches, way_pitches], each) / way_pitches
}

/// Half the variance of what the parity's mean across differs by between both ends of the way, over the parity's own.
///
/// The mean over y of the segments that measure x, of either side, is that of teeth of their own at either end. Those that measure y stand
/// half a span to either side in x: where the span is about as long as the way, one comes at the end to the teeth at which the other began,
/// and with the other sign, so that both ends see them alike in the difference.
fn ends(span_pitches: f64, way_pitches: f64) -> f64 {
    let (span, way) = (span_pitches, way_pitches);
    let mean = means_alike(0.0, way);
    let measured_along = 4.0 * (mean - means_alike(span, way)) * (1.0 - alike(way));
    let apart = 2.0 * alike(way) + 2.0 * alike(span) - alike(way - span) - alike(way + span);
    let measured_across = 2.0 * mean * (2.0 - apart);
    0.5 * (measured_along + measured_across) / (4.0 * (1.0 - alike(span)))
}

/// By the midpoint rule.
fn integral([from, to]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    let width = (to - from) / f64::from(STEPS);
    (0..STEPS)
        .map(|k| width * of(from + (f64::from(k) + 0.5) * width))
        .sum()
}

/// Whether the constants are in a self-calibration's gauge.
fn spread(calibration: &Calibration) -> bool {
    let [first, ..] = calibration.model.constants_m;
    let size = first.abs().max(f32::MIN_POSITIVE);
    let constants = calibration.model.constants_m.iter().zip(PARITY_SIGN);
    constants
        .into_iter()
        .all(|(k, sign)| (k * sign - first * PARITY_SIGN[0]).abs() <= ROUNDING * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::record;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Against drawn teeth: the parity's mean over y at both ends of the way, and its variance. A span as long as the way sees the same teeth at
    /// both; a fifth more than with teeth of their own, which is what is told apart here.
    #[test]
    fn both_ends_differ_as_those_of_drawn_teeth_do() {
        const TEETH: usize = 48;
        const DRAWS: u32 = 1500;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let span = TRAVEL_PITCHES;
        let read = |field: &[f64], along: f64, across: f64| -> f64 {
            let weights = |at: f64| {
                let first = (at - HALF_PITCHES).ceil() as usize;
                (first..first + 6).map(move |k| {
                    (
                        k,
                        (1.0 - ((k as f64 - at) / HALF_PITCHES).powi(2))
                            .max(0.0)
                            .powi(2),
                    )
                })
            };
            let row = |i: usize| {
                weights(across)
                    .map(|(j, w)| w * field[i * TEETH + j])
                    .sum::<f64>()
            };
            weights(along).map(|(i, w)| w * row(i)).sum()
        };
        let (mut differing, mut whole) = (0.0, 0.0);
        for _ in 0..DRAWS {
            let fields: [Vec<f64>; 2] = std::array::from_fn(|_| {
                (0..TEETH * TEETH)
                    .map(|_| StandardNormal.sample(&mut rng))
                    .collect()
            });
            let parity = |x: f64, y: f64| {
                let (x, y, half) = (x + 18.0, y + 18.0, 0.5 * span);
                read(&fields[0], x, y + half)
                    - read(&fields[0], x, y - half)
                    - read(&fields[1], y, x - half)
                    + read(&fields[1], y, x + half)
            };
            let mean = |x: f64| {
                (0..20)
                    .map(|k| parity(x, 0.5 * f64::from(k) + 0.25))
                    .sum::<f64>()
                    / 20.0
            };
            differing += (mean(0.0) - mean(TRAVEL_PITCHES)).powi(2);
            whole += parity(0.3, 0.7).powi(2);
        }
        let (found, wanted) = (0.5 * differing / whole, ends(span, TRAVEL_PITCHES));
        let mean = means_alike(0.0, TRAVEL_PITCHES);
        // Two variances of so many draws.
        let deviation = (4.0 / f64::from(DRAWS)).sqrt();
        assert!(
            (found / wanted - 1.0).abs() < 3.0 * deviation,
            "{found} {wanted}"
        );
        assert!(wanted > 1.19 * mean && (ends(40.0, TRAVEL_PITCHES) / mean - 1.0).abs() < 1.0e-6);
    }

    #[test]
    fn a_record_that_tells_none_is_named() {
        let told = |change: fn(&mut Calibration)| {
            let mut calibration = record();
            change(&mut calibration);
            of(&calibration).unwrap_err()
        };
        assert!(told(|c| c.quality.poses = 0).contains("not made by"));
        assert!(told(|c| c.quality.unknowns = 41).contains("loaded over"));
        assert!(told(|c| c.model.constants_m = [1.0e-6, 2.0e-6, 0.0, 0.0]).contains("loaded over"));
        assert!(told(|c| c.quality.poses = 34).contains("34 poses"));
        assert!(told(|c| c.quality.residual_after_m = 0.0).contains("0e0 m left"));
    }
}
