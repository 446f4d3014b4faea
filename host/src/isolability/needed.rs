//! How many poses the error model's coefficients need, against a thousand random ones, and the least that any motion needs.

use super::problem::Problem;
use super::question::{Motion, Question};
use courier_sensor::calibration::joint::Unknown;
use courier_sensor::geometry::Geometry;
use serde::Serialize;

/// Nobody visits more poses. A prior: at a second a pose they would take twelve days.
const MANY: f64 = 1.0e6;
/// Poses of the paper's 3.2.1.
const REFERENCE_POSES: u32 = 1000;
/// Their range along x and y, m: two pitches (paper, 3.2.1).
const REFERENCE_TRAVEL_M: f32 = 2.0 * Geometry::PAPER.pitch_m;
/// Their largest angle, rad: 1.5 degrees (paper, 3.2.1).
const REFERENCE_TURN_RAD: f32 = 1.5_f32.to_radians();

/// Poses that the coefficients of equations (3) and (9) need.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Needed {
    /// Rms of the coefficients' predicted deviations by the planned motion, metres.
    pub coefficients_m: f64,
    /// The same by 1000 random poses under the beacon within two pitches and ±1.5°.
    pub reference_m: f64,
    /// Poses of the planned kind that come to the reference's deviation; none if a million are too few.
    pub poses: Option<u32>,
    /// No motion does with fewer: were the true pose known at each, a segment's reading would still be a sine and a cosine of
    /// each order with its own noise, and their deviation at least noise times the root of 2 / poses.
    pub least_of_any_motion: u32,
}

/// For the beacon's unknowns; none where the motion leaves a coefficient undetermined.
pub(super) fn of(question: &Question, planned: &Problem) -> Option<Needed> {
    let coefficients_m = planned.coefficients_m()?;
    let reference = Motion {
        poses: REFERENCE_POSES,
        travel_m: REFERENCE_TRAVEL_M,
        turn_rad: REFERENCE_TURN_RAD,
        beacon: true,
        chosen: false,
        seed: question.motion.seed,
    };
    let reference = Question {
        motion: reference,
        ..question.clone()
    };
    let reference_m = Problem::new(&reference).coefficients_m()?;
    let poses = f64::from(question.motion.poses) * (coefficients_m / reference_m).powi(2);
    let least = 2.0 * (f64::from(question.noise_m) / reference_m).powi(2);
    Some(Needed {
        coefficients_m,
        reference_m,
        poses: (poses <= MANY).then(|| poses.ceil() as u32),
        least_of_any_motion: least.ceil() as u32,
    })
}

impl Problem {
    /// Rms of the predicted deviations of all coefficients; none if one is undetermined.
    fn coefficients_m(&self) -> Option<f64> {
        let variances = self.triangle.variances();
        let of_coefficients: Vec<f64> = (0..self.free.len())
            .filter(|&c| {
                let unknown = self.layout.unknown(self.free[c]);
                matches!(unknown, Unknown::Coefficient { .. })
            })
            .map(|c| variances[c])
            .collect();
        let mean = of_coefficients.iter().sum::<f64>() / of_coefficients.len() as f64;
        mean.is_finite().then(|| mean.sqrt())
    }
}
