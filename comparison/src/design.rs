//! The covariance of a platen calibration by what its record keeps of it.
//!
//! The record has no covariance: 33 unknowns would take its room twice. It has the number of poses N, what the parity of held-out
//! poses left, and the worst predicted deviation of a correction; the motion is uniform over phases. So the rows of equation (7) have
//! the expected products
//!
//! ```text
//! N/2 [ 1    -C_n ]     between the same function of order n of both segments of a pair, zero between all others,
//!     [ -C_n    1 ]
//! ```
//! where `C_n` is the mean of `cos(n d)` over the poses and d the difference of the pair's phases, `2 pi span theta / pitch`. With angles
//! uniform over a turn to either side that is `sin(n d) / (n d)` at the largest d. That is not in the record; the worst predicted
//! deviation, `noise^2 2/N sum 1 / (1 - C_n^2)` (`courier_sensor::calibration::Planner`), tells it.
//!
//! What is left in the parity is no noise that is another at each pose, but mostly displaced teeth, the same whenever the courier comes by.
//! Over whole waves a smooth field has no part of order n, but the poses end somewhere: its mean r(x) over the way across has, over a way
//! of L pitches along, the part
//!
//! ```text
//! a_n = (r(0) - r(L)) / (pi n L),   by the first step of an integration by parts
//! ```
//! in a sine whose zero is at the edge, and none in the cosine. Both segments of a pair see it alike, so the fit puts it into their
//! difference: `a_n B_n / (1 + C_n)` into one and the same with the other sign into the other, B_n the mean of `cos(n d / 2)`. No number
//! of poses makes it smaller, and at another place it is another one.

use courier_sensor::calibration::record::Calibration;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{Multiplier, Term};

/// Poses held out unless that was asked otherwise (`Visits::paper`), by which the noise is known: the record does not say.
pub(crate) const HELD_OUT: f64 = 200.0;
/// Way of the poses in x and y unless that was asked otherwise (`Visits::paper`), pitches: the record does not say.
const TRAVEL_PITCHES: f64 = 10.0;
/// Share of a tooth field's variance that its mean over that way across has: `2/L` times the integral of `(1 - y/L) rho(y)`, rho the
/// correlation of what a segment reads that averages six teeth, as the paper's does, with weights `(1 - u^2)^2`.
const MEAN_ACROSS: f64 = 0.365;
/// Largest of four independent standard normal numbers, expected (Harter 1961, Biometrika 48, 151): of four segments the worst is kept.
const LARGEST_OF_FOUR: f64 = 1.029;
/// Constants of a self-calibration are equal but for their signs, to rounding of f32.
const ROUNDING: f32 = 1.0e-5;

/// What a record tells of its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Orders fitted, equal for all segments.
    pub orders: Vec<u8>,
    /// Variance of each coefficient, m^2, by order as in `orders`.
    pub variance: Vec<f64>,
    /// Correlation of the same coefficients of both segments of a pair, but for the teeth's part.
    pub correlation: Vec<f64>,
    /// Variance of each coefficient by the teeth of the place, m^2; of opposite sign in both segments of a pair.
    pub teeth: Vec<f64>,
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
    let wanted = (worst_m / noise_m).powi(2) * poses / (2.0 * scatter * of_four);
    let difference_rad = difference(&orders, wanted);
    let correlation: Vec<f64> = orders
        .iter()
        .map(|&order| sinc(f64::from(order) * difference_rad))
        .collect();
    // Chosen poses do better than random ones: where no turn of these is as good, all variances are as much less.
    let better = (wanted / orders.len() as f64).min(1.0);
    let alone_m2 = noise_m * noise_m * 2.0 / poses * scatter * better;
    let variance = correlation.iter().map(|c| alone_m2 / (1.0 - c * c));
    let teeth = orders
        .iter()
        .zip(&correlation)
        .map(|(&order, c)| teeth(order.into(), *c, difference_rad, noise_m));
    Ok(Design {
        teeth: teeth.collect(),
        variance: variance.collect(),
        correlation,
        noise_m,
        freedom: (HELD_OUT - 1.0).min(poses - count + 1.0),
        poses: quality.poses,
        orders,
    })
}

/// Variance of a coefficient by the teeth of the place, the parity's rest being `left_m` of teeth: both ends of the way have fields of their
/// own, and where in a wave they lie is not known.
fn teeth(order: f64, correlation: f64, difference_rad: f64, left_m: f64) -> f64 {
    let edge = 1.0 / (std::f64::consts::PI * order * TRAVEL_PITCHES);
    let seen = sinc(0.5 * order * difference_rad) / (1.0 + correlation);
    MEAN_ACROSS * (left_m * edge * seen).powi(2)
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

fn sinc(x: f64) -> f64 {
    if x.abs() < 1.0e-6 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

/// Sum of `1 / (1 - C_n^2)`.
fn weakness(orders: &[u8], difference_rad: f64) -> f64 {
    let one = |&order: &u8| 1.0 / (1.0 - sinc(f64::from(order) * difference_rad).powi(2));
    orders.iter().map(one).sum()
}

/// The largest difference of a pair's phases whose weakness is as wanted, by bisection; where none is as small, half a turn of the
/// lowest order, from where on turning further gains nothing.
fn difference(orders: &[u8], wanted: f64) -> f64 {
    let (mut low, mut high) = (1.0e-4, std::f64::consts::PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if weakness(orders, middle) > wanted {
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
        let orders = [1, 2, 4, 6];
        let paper_rad = std::f64::consts::TAU * 9.7 / 1.016 * 8.727e-3;
        assert!((2.0 * weakness(&orders, paper_rad) - 33.6).abs() < 0.3);
        assert!((difference(&orders, weakness(&orders, paper_rad)) - paper_rad).abs() < 1.0e-9);
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
            of(&calibration).unwrap().variance
        };
        // The least of random poses: four orders, 8 / N in squares of the noise, some more for their scatter.
        let (low, lower) = (of_worst(0.06e-6), of_worst(0.06e-6 / 2.0_f32.sqrt()));
        for (low, lower) in low.iter().zip(&lower) {
            assert!((low / lower - 2.0).abs() < 1.0e-4, "{low:e} {lower:e}");
        }
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
