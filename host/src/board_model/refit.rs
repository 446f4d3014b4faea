//! From the phases of the diagnosis to those of the board.
//!
//! The diagnosis writes an effect in corrected phases, for that is what it physically depends on. The board has unmodified
//! ones (equations 3 and 9), which an error of 16 µm shifts by 0.1 rad: terms of 6 µm taken over as they are would leave
//! 0.6 µm. So the board's coefficients are fitted, by least squares, to the correction that the diagnosed model makes, over
//! poses of every phase. What they cannot follow is returned.

use super::row::{Row, USUAL_ANGLE_RAD};
use anyhow::{Context, Result};
use courier_sensor::equations::{lateral_arguments, middle, outputs, theta};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{Multiplier, Term};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Poses. Derived from the fit's columns: some fifty to each, evenly spread, so that no term is taken for another.
const POSES: usize = 2500;
/// Rounds in which the unmodified output is found. Derived from the slope of the corrections, a tenth where errors are 16 µm:
/// each gains a factor of ten, and twelve digits are reached.
const ROUNDS: usize = 12;

/// The correction that a diagnosed model makes.
pub struct Diagnosed<'a> {
    /// Equation (3), in unmodified phases.
    pub own: &'a [Row],
    /// The effects' terms, in corrected phases.
    pub effects: &'a [Row],
    /// k_0 of each segment, m.
    pub constants_m: [f64; SEGMENTS],
}

/// Coefficients for the board's phases.
pub struct Refitted {
    /// The rows that were to be fitted, with their coefficients.
    pub rows: Vec<Row>,
    /// k_0 of each segment, m.
    pub constants_m: [f64; SEGMENTS],
    /// What is left of the correction, rms over all segments and phases, m.
    pub left_m: f64,
}

/// One pose as both sides see it.
struct Pose {
    /// Phases of the unmodified outputs: the board's.
    unmodified: Phases,
    /// Correction of each segment, m.
    correction_m: [f64; SEGMENTS],
}

/// Own and lateral phases of all segments, and the angle.
#[derive(Clone, Copy)]
struct Phases {
    own: [f64; SEGMENTS],
    lateral: [f64; SEGMENTS],
    theta_rad: f64,
}

impl Phases {
    /// As the firmware forms them from four outputs (equation 9).
    fn new(p: &[f64; SEGMENTS], geometry: &Geometry) -> Self {
        let f = TAU / f64::from(geometry.pitch_m);
        let theta_rad = theta(p, f64::from(geometry.span_m));
        let lateral_m = lateral_arguments(middle(p), theta_rad, f64::from(geometry.lateral_m));
        Self {
            own: p.map(|p| f * p),
            lateral: lateral_m.map(|q| f * q),
            theta_rad,
        }
    }

    fn waves(&self, term: &Term, segment: usize) -> [f64; 2] {
        let phase = f64::from(term.own_order) * self.own[segment]
            + f64::from(term.lateral_order) * self.lateral[segment];
        let (sine, cosine) = phase.sin_cos();
        let factor = self.theta_rad.powi(i32::from(term.theta_power));
        [factor * sine, factor * cosine]
    }

    fn sum_m(&self, rows: &[Row], segment: usize) -> f64 {
        let part = |row: &Row| {
            let [a, b] = row.coefficients[segment];
            let [sine, cosine] = self.waves(&row.term, segment);
            a * sine + b * cosine
        };
        rows.iter().filter(|row| of_phase(row)).map(part).sum()
    }
}

/// Rows with a multiplier keep their coefficients: they are of other quantities than the phases.
fn of_phase(row: &Row) -> bool {
    row.term.multiplier == Multiplier::None
}

/// Fits the coefficients of `rows`.
///
/// # Errors
/// The rows are not told apart by any motion.
pub fn refit(diagnosed: &Diagnosed, rows: &[Row], geometry: &Geometry) -> Result<Refitted> {
    let poses: Vec<Pose> = (0..POSES).map(|k| pose(diagnosed, geometry, k)).collect();
    let mut rows = rows.to_vec();
    let terms: Vec<Term> = rows
        .iter()
        .filter(|row| of_phase(row))
        .map(|row| row.term)
        .collect();
    let (mut constants_m, mut square) = ([0.0; SEGMENTS], 0.0);
    for segment in 0..SEGMENTS {
        let columns = 1 + 2 * terms.len();
        let matrix = DMatrix::from_fn(POSES, columns, |k, column| match column.checked_sub(1) {
            Some(column) => poses[k].unmodified.waves(&terms[column / 2], segment)[column % 2],
            None => 1.0,
        });
        let wanted = DVector::from_fn(POSES, |k, _| poses[k].correction_m[segment]);
        let qr = matrix.clone().qr();
        let solution = qr
            .r()
            .solve_upper_triangular(&(qr.q().transpose() * &wanted))
            .context("terms: found two that no motion tells apart, wanted different ones")?;
        square += (&matrix * &solution - wanted).norm_squared();
        constants_m[segment] = solution[0];
        for (index, row) in rows.iter_mut().filter(|row| of_phase(row)).enumerate() {
            row.coefficients[segment] = [solution[1 + 2 * index], solution[2 + 2 * index]];
        }
    }
    let left_m = (square / (POSES * SEGMENTS) as f64).sqrt();
    Ok(Refitted {
        rows,
        constants_m,
        left_m,
    })
}

/// What rows leave of the correction as they are, rms over all segments and phases about each segment's mean, m.
#[cfg(test)]
pub fn miss_m(diagnosed: &Diagnosed, rows: &[Row], geometry: &Geometry) -> f64 {
    let poses: Vec<Pose> = (0..POSES).map(|k| pose(diagnosed, geometry, k)).collect();
    let miss = |pose: &Pose, s: usize| pose.unmodified.sum_m(rows, s) - pose.correction_m[s];
    let square = (0..SEGMENTS).map(|s| {
        let mean = poses.iter().map(|pose| miss(pose, s)).sum::<f64>() / POSES as f64;
        poses
            .iter()
            .map(|pose| (miss(pose, s) - mean).powi(2))
            .sum::<f64>()
    });
    (square.sum::<f64>() / (POSES * SEGMENTS) as f64).sqrt()
}

/// Pose `k` of a sequence that fills phases and angles evenly (Roberts 2018, "The unreasonable effectiveness of
/// quasirandom sequences").
fn pose(diagnosed: &Diagnosed, geometry: &Geometry, k: usize) -> Pose {
    /// Plastic number of three dimensions, whose powers' multiples fill a cube evenly (Roberts 2018).
    const PLASTIC: f64 = 1.220_744_084_605_759_5;
    let unit = |power: i32| (0.5 + (k + 1) as f64 * PLASTIC.powi(-power)).fract();
    let pitch_m = f64::from(geometry.pitch_m);
    let (x, y, theta) = (
        pitch_m * unit(1),
        pitch_m * unit(2),
        USUAL_ANGLE_RAD * (2.0 * unit(3) - 1.0),
    );
    let corrected = outputs([x, y], theta, f64::from(geometry.span_m));
    let phases = Phases::new(&corrected, geometry);
    let effects = std::array::from_fn::<f64, SEGMENTS, _>(|s| {
        diagnosed.constants_m[s] + phases.sum_m(diagnosed.effects, s)
    });
    let mut unmodified = corrected;
    for _ in 0..ROUNDS {
        let seen = Phases::new(&unmodified, geometry);
        unmodified =
            std::array::from_fn(|s| corrected[s] - effects[s] - seen.sum_m(diagnosed.own, s));
    }
    Pose {
        unmodified: Phases::new(&unmodified, geometry),
        correction_m: std::array::from_fn(|s| corrected[s] - unmodified[s]),
    }
}
