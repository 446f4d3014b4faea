//! The rows of a calibration's fit as they are expected, where its record names no poses.
//!
//! A record of version 2 does not say which poses it visited, nor how far the courier was turned. Random ones are even over true places, so their
//! rows have known expected products ([`Phases`]). Those of segments without waves are
//!
//! ```text
//! N/2 [ 1    -C_n ]     between the same function of order n of both segments of a pair, zero between all others,
//!     [ -C_n    1 ]
//! ```
//! where `C_n` is the mean of `cos(n d)` over the poses and d the difference of the pair's phases, `2 pi span theta / pitch`. With angles
//! even over a turn to either side that is `sin(n d) / (n d)` at the largest d. The worst predicted deviation, which the same products give
//! (`courier_sensor::calibration::GatedFit`), tells it. Waves of 30 µm make a segment's orders go together by tens of percent.

use crate::phases::Phases;
use crate::rows::{Rows, waves};
use courier_sensor::calibration::record::Calibration;
use nalgebra::DMatrix;

/// Poses held out unless that was asked otherwise, by which the noise is known: a record of version 2 does not say. By definition as many
/// as `Visits::paper` has.
pub const HELD_OUT: f64 = 200.0;
/// Largest of four independent standard normal numbers, expected (Harter 1961, Biometrika 48, 151): of four segments the worst is kept.
const LARGEST_OF_FOUR: f64 = 1.029;

/// By a record that names no poses.
pub fn rows(orders: &[u8], calibration: &Calibration) -> Option<Rows> {
    let quality = &calibration.quality;
    let (poses, count) = (f64::from(quality.poses), f64::from(quality.unknowns));
    let [left_m, worst_m] = [quality.residual_after_m, quality.predicted_worst_m].map(f64::from);
    // Random rows: the expected inverse of their products is that of the expected products, times this (Wishart 1928).
    let scatter = poses / (poses - count - 1.0);
    let leverage = count / poses * scatter;
    let of_four = 1.0 + LARGEST_OF_FOUR * (2.0 / (poses - count)).sqrt();
    let wanted = (worst_m / left_m).powi(2) * (1.0 + leverage) * poses / (scatter * of_four);
    let (phases, difference_rad) = passed(orders, calibration, wanted);
    let per_pose = inverse(&phases, difference_rad)?;
    // Chosen poses do better than random ones: where no turn of these is as good, all variances are as much less.
    let better = (wanted / phases.largest(&per_pose)).min(1.0);
    Some(Rows {
        per_pose,
        share: scatter * better,
        leverage,
        freedom: (HELD_OUT - 1.0).min(poses - count + 1.0),
        lateral: None,
        phases,
        difference_rad,
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

/// Inverse of the expected products of a pose's row with itself.
fn inverse(phases: &Phases, difference_rad: f64) -> Option<DMatrix<f64>> {
    let factor = phases.products(difference_rad).cholesky()?;
    Some(factor.inverse())
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
    use crate::phases::sinc;
    use crate::rows::{radians_per_turn, record};

    const ORDERS: [u8; 4] = [1, 2, 4, 6];

    /// The paper's motion: 33.6 / N in squares of the noise.
    #[test]
    fn the_worst_deviation_tells_the_turn() {
        let phases = Phases::new(&ORDERS, &waves(&record()));
        let paper_rad = radians_per_turn(&record()) * 8.727e-3;
        let worst = phases.largest(&inverse(&phases, paper_rad).unwrap());
        assert!((worst - 33.6).abs() < 0.3, "{worst}");
        assert!((difference(&phases, worst) - paper_rad).abs() < 1.0e-9);
        let found = rows(&ORDERS, &record()).unwrap().difference_rad;
        assert!((sinc(found) - sinc(paper_rad)).abs() < 0.02, "{found}");
    }

    /// Half of what random poses leave at the best: half the variance.
    #[test]
    fn chosen_poses_are_as_good_as_their_record_says() {
        let of_worst = |worst_m: f32| {
            let mut calibration = record();
            calibration.quality.predicted_worst_m = worst_m;
            rows(&ORDERS, &calibration).unwrap()
        };
        // The least of random poses: four orders, 8 / N in squares of the noise, some more for their scatter.
        let [low, lower] = [1.0, 0.5_f32].map(|share| of_worst(0.06e-6 * share.sqrt()));
        assert!((low.share / lower.share - 2.0).abs() < 1.0e-4);
        assert_eq!(low.per_pose, lower.per_pose);
    }
}
