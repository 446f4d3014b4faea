//! What is known of the rows of a calibration's fit, and what they follow from.

use crate::lateral::Lateral;
use crate::phases::{Phases, Waves};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{Multiplier, Term};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// What is known of the rows of a fit.
pub struct Rows {
    /// Inverse of the mean products of a pose's row with itself.
    pub per_pose: DMatrix<f64>,
    /// Covariance of the coefficients over `per_pose`, times the poses, for unit noise.
    pub share: f64,
    /// How much the fit's uncertainty adds to the variance of a held-out parity, for unit noise.
    pub leverage: f64,
    /// Degrees of freedom with which the covariance's scale is known.
    pub freedom: f64,
    /// What lateral terms make of it, for unit noise, where the poses are known.
    pub lateral: Option<Lateral>,
    /// Over which the poses were even.
    pub phases: Phases,
    /// Largest difference of a pair's phases.
    pub difference_rad: f64,
}

/// By how much a pair's phases differ for each radian of the courier's.
pub fn radians_per_turn(calibration: &Calibration) -> f64 {
    let geometry = &calibration.geometry;
    TAU * f64::from(geometry.span_m / geometry.pitch_m)
}

/// What was fitted, in shares of a radian.
pub fn waves(calibration: &Calibration) -> [Waves; SEGMENTS] {
    let per_m = TAU / f64::from(calibration.geometry.pitch_m);
    let terms = calibration.model.terms.iter();
    let terms = terms.zip(&calibration.model.coefficients);
    let fitted: Vec<_> = terms.filter(|(term, _)| fitted(term)).collect();
    std::array::from_fn(|segment| {
        let of = fitted.iter().map(|(_, rows)| rows[segment]);
        of.map(|pair| pair.map(|k| per_m * f64::from(k))).collect()
    })
}

/// What the board fits by the parity alone.
pub fn fitted(term: &Term) -> bool {
    *term == Term::own(term.own_order) && term.multiplier == Multiplier::None && term.own_order != 0
}

/// A calibration with the paper's motion and without waves, for tests: 1000 poses, 1 µm left.
#[cfg(test)]
pub fn record() -> Calibration {
    let mut calibration = Calibration::identity(courier_sensor::geometry::Geometry::PAPER);
    calibration.model =
        courier_sensor::model::ErrorModel::zero(courier_sensor::model::TermTable::equation_3());
    let quality = &mut calibration.quality;
    (quality.poses, quality.unknowns, quality.rank) = (1000, 33, 33);
    (quality.residual_after_m, quality.predicted_worst_m) = (1.0e-6, 0.195e-6);
    calibration
}
