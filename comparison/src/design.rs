//! The covariance of a platen calibration by what its record keeps of it.
//!
//! The record has no covariance: 33 unknowns would take its room twice. It has the number of poses N, what the parity of held-out
//! poses left, the worst predicted deviation of a correction, and the waves themselves; the motion is even over true places. So the
//! rows of equation (7) have known expected products ([`Phases`]). Those of segments without waves are
//!
//! ```text
//! N/2 [ 1    -C_n ]     between the same function of order n of both segments of a pair, zero between all others,
//!     [ -C_n    1 ]
//! ```
//! where `C_n` is the mean of `cos(n d)` over the poses and d the difference of the pair's phases, `2 pi span theta / pitch`. With angles
//! even over a turn to either side that is `sin(n d) / (n d)` at the largest d. That is not in the record; the worst predicted
//! deviation, which the same products give (`courier_sensor::calibration::GatedFit`), tells it. Waves of 30 µm make a segment's orders go
//! together by tens of percent.
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

use crate::phases::{Phases, Waves, sinc};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{Multiplier, Term};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Poses held out unless that was asked otherwise, by which the noise is known: the record does not say. By definition as many as
/// `Visits::paper` has.
pub(crate) const HELD_OUT: f64 = 200.0;
/// Way of the poses in x and y unless that was asked otherwise, pitches: the record does not say. By definition that of
/// `Visits::paper` (paper, 3.1.2).
const TRAVEL_PITCHES: f64 = 10.0;
/// Half of a segment that averages six teeth, pitches: with weights `(1 - u^2)^2`. A prior: 1.9 µm of tooth variation under such
/// a segment leave the paper's 4.1 µm of parity (3.1.2).
const HALF_PITCHES: f64 = 3.0;
/// Steps of the midpoint rule over a segment or a way. Derived from its error, a thousandth of the integral at the most.
const STEPS: i32 = 200;
/// Largest of four independent standard normal numbers, expected (Harter 1961, Biometrika 48, 151): of four segments the worst is kept.
const LARGEST_OF_FOUR: f64 = 1.029;
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
    /// Poses that were fitted.
    pub poses: u16,
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
    // Random rows: the expected inverse of their products is that of the expected products, times this (Wishart 1928).
    let scatter = poses / (poses - count - 1.0);
    // A held-out parity has the fit's uncertainty beside its own noise.
    let noise_m = left_m / (1.0 + count / poses * scatter).sqrt();
    let of_four = 1.0 + LARGEST_OF_FOUR * (2.0 / (poses - count)).sqrt();
    let wanted = (worst_m / noise_m).powi(2) * poses / (scatter * of_four);
    let (phases, difference_rad) = passed(&orders, calibration, wanted);
    let inverse = inverse(&phases, difference_rad)
        .ok_or("its waves are larger than an error that can be undone: they tell no covariance")?;
    // Chosen poses do better than random ones: where no turn of these is as good, all variances are as much less.
    let better = (wanted / phases.largest(&inverse)).min(1.0);
    let of_noise = &inverse * (noise_m * noise_m / poses * scatter * better);
    let geometry = &calibration.geometry;
    let step_m2 = 2.0 * noise_m * noise_m * ends(f64::from(geometry.span_m / geometry.pitch_m));
    let of_wave = step_m2 / (TAU * TRAVEL_PITCHES).powi(2);
    let teeth = &inverse * phases.at_edge(difference_rad) * &inverse * of_wave;
    Ok(Design {
        covariance: symmetric(&(of_noise + teeth)),
        correlation: orders
            .iter()
            .map(|&order| sinc(f64::from(order) * difference_rad))
            .collect(),
        noise_m,
        freedom: (HELD_OUT - 1.0).min(poses - count + 1.0),
        poses: quality.poses,
        orders,
    })
}

/// How the poses passed the phases, and the largest difference of a pair's. Random poses are even over places, chosen ones over the phases that are
/// read: with either there is a turn that gives the worst deviation, but another condition number, and that is in the record.
fn passed(orders: &[u8], calibration: &Calibration, wanted: f64) -> (Phases, f64) {
    let waves = waves(calibration);
    let none = waves.each_ref().map(|waves| vec![[0.0; 2]; waves.len()]);
    let condition = f64::from(calibration.quality.condition_number);
    let [(random, off_random), (chosen, off_chosen)] = [waves, none].map(|waves| {
        let phases = Phases::new(orders, &waves);
        let difference_rad = difference(&phases, wanted);
        let off = (phases.condition(difference_rad) / condition).ln().abs();
        ((phases, difference_rad), off)
    });
    if off_chosen < off_random {
        chosen
    } else {
        random
    }
}

/// What was fitted, in shares of a radian.
fn waves(calibration: &Calibration) -> [Waves; SEGMENTS] {
    let per_m = TAU / f64::from(calibration.geometry.pitch_m);
    let terms = calibration.model.terms.iter();
    let terms = terms.zip(&calibration.model.coefficients);
    let fitted: Vec<_> = terms.filter(|(term, _)| fitted(term)).collect();
    std::array::from_fn(|segment| {
        let of = fitted.iter().map(|(_, rows)| rows[segment]);
        of.map(|pair| pair.map(|k| per_m * f64::from(k))).collect()
    })
}

/// Without what rounding makes unlike.
fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (matrix + matrix.transpose())
}

/// Inverse of the expected products of a pose's row with itself.
fn inverse(phases: &Phases, difference_rad: f64) -> Option<DMatrix<f64>> {
    let factor = phases.products(difference_rad).cholesky()?;
    Some(factor.inverse())
}

/// How two readings of a tooth field go together that are so many pitches apart along or across: the weights' autocorrelation.
fn alike(away_pitches: f64) -> f64 {
    let weight = |u: f64| (1.0 - u * u).max(0.0).powi(2);
    let away = away_pitches / HALF_PITCHES;
    let sum = |away: f64| integral([-1.0, 1.0], |u| weight(u) * weight(u + away));
    sum(away) / sum(0.0)
}

/// The same of two means over the way that are so many pitches apart.
fn means_alike(away_pitches: f64) -> f64 {
    let each = |t: f64| (1.0 - t.abs() / TRAVEL_PITCHES) * alike(away_pitches + t);
    integral([-TRAVEL_PITCHES, TRAVEL_PITCHES], each) / TRAVEL_PITCHES
}

/// Half the variance of what the parity's mean across differs by between both ends of the way, over the parity's own.
///
/// The mean over y of the segments that measure x, of either side, is that of teeth of their own at either end. Those that measure y stand
/// half a span to either side in x: where the span is about as long as the way, one comes at the end to the teeth at which the other began,
/// and with the other sign, so that both ends see them alike in the difference.
fn ends(span_pitches: f64) -> f64 {
    let (span, way) = (span_pitches, TRAVEL_PITCHES);
    let mean = means_alike(0.0);
    let measured_along = 4.0 * (mean - means_alike(span)) * (1.0 - alike(way));
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

/// What the board fits by the parity alone.
pub fn fitted(term: &Term) -> bool {
    *term == Term::own(term.own_order) && term.multiplier == Multiplier::None && term.own_order != 0
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

/// The largest difference of a pair's phases with which the worst variance is as wanted, by bisection; where none is as small, half a turn
/// of the lowest order, from where on turning further gains nothing.
fn difference(phases: &Phases, wanted: f64) -> f64 {
    let (mut low, mut high) = (1.0e-3, std::f64::consts::PI);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let worst = inverse(phases, middle).map(|inverse| phases.largest(&inverse));
        if worst.is_none_or(|worst| worst > wanted) {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, TermTable};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn record() -> Calibration {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = ErrorModel::zero(TermTable::equation_3());
        let quality = &mut calibration.quality;
        (quality.poses, quality.unknowns, quality.rank) = (1000, 33, 33);
        (quality.residual_after_m, quality.predicted_worst_m) = (1.0e-6, 0.195e-6);
        calibration
    }

    /// The paper's motion: 33.6 / N in squares of the noise.
    #[test]
    fn the_worst_deviation_tells_the_turn() {
        let phases = Phases::new(&[1, 2, 4, 6], &waves(&record()));
        let paper_rad = TAU * 9.7 / 1.016 * 8.727e-3;
        let worst = phases.largest(&inverse(&phases, paper_rad).unwrap());
        assert!((worst - 33.6).abs() < 0.3, "{worst}");
        assert!((difference(&phases, worst) - paper_rad).abs() < 1.0e-9);
        let design = of(&record()).unwrap();
        let paper = sinc(paper_rad);
        assert!(
            (design.correlation[0] - paper).abs() < 0.02,
            "{design:?} {paper}"
        );
        assert!(
            design.correlation[0] > 0.9 && design.correlation[3].abs() < 0.1,
            "{design:?}"
        );
    }

    /// Half of what random poses leave at the best: half the variance.
    #[test]
    fn chosen_poses_are_as_good_as_their_record_says() {
        let of_worst = |worst_m: f32| {
            let mut calibration = record();
            calibration.quality.predicted_worst_m = worst_m;
            of(&calibration).unwrap().covariance
        };
        // The least of random poses: four orders, 8 / N in squares of the noise, some more for their scatter.
        let [low, lower, lowest] =
            [1.0, 0.5_f32, 0.25].map(|share| of_worst(0.06e-6 * share.sqrt()));
        // The teeth's part is the same.
        for k in 0..low.nrows() {
            let ratio = (low[(k, k)] - lower[(k, k)]) / (lower[(k, k)] - lowest[(k, k)]);
            assert!((ratio - 2.0).abs() < 1.0e-4, "{ratio}");
        }
    }

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
        let (found, wanted) = (0.5 * differing / whole, ends(span));
        // Two variances of so many draws.
        let deviation = (4.0 / f64::from(DRAWS)).sqrt();
        assert!(
            (found / wanted - 1.0).abs() < 3.0 * deviation,
            "{found} {wanted}"
        );
        assert!(
            wanted > 1.19 * means_alike(0.0)
                && (ends(40.0) / means_alike(0.0) - 1.0).abs() < 1.0e-6
        );
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
