//! g_p, g_x and g_y of a pose (equations 5, 10, 11), their derivatives by the unknowns, and their covariance.

use super::model::outputs;
use super::pose::{Setup, TeethPose};
use super::unknowns::Unknowns;
use courier_sensor::equations::{Angle, beacon, by_outputs, middle, parity, theta};
use courier_sensor::frame::SEGMENTS;
use nalgebra::Matrix3;

/// Readings' noise, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of a segment.
    pub segment_m: f64,
    /// Of a displacement under the beacon.
    pub displacement_m: f64,
}

/// One pose linearised.
#[derive(Clone, Debug)]
pub struct Linear {
    /// g_p, g_x, g_y, metres.
    pub g_m: [f64; 3],
    /// `(unknown, derivatives of the three)`.
    pub by: Vec<(usize, [f64; 3])>,
    /// Derivatives by the calibrated outputs, `[segment][constraint]`.
    by_outputs: [[f64; 3]; SEGMENTS],
}

/// Displacement of the beacon in the sensor's frame: raw deflection to metres.
struct Displacement {
    c_m: [f64; 2],
    scale_m: f64,
}

fn displacement(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    [u, v]: [f64; 2],
) -> Displacement {
    let (gain, turn) = (
        values[unknowns.misalignment()],
        values[unknowns.misalignment() + 1],
    );
    let bend = |axis: usize, own: f64, other: f64| -> f64 {
        let coefficients = &values[unknowns.bend(axis)..unknowns.bend(axis + 1)];
        unknowns
            .powers
            .iter()
            .zip(coefficients)
            .map(|((n, m), k)| k * own.powi(*n) * other.powi(*m))
            .sum()
    };
    let scale_m = values[unknowns.mounting()] * setup.tan_full_scale;
    let x = u + gain * u - turn * v + bend(0, u, v);
    let y = v - gain * v + turn * u + bend(1, v, u);
    Displacement {
        c_m: [x * scale_m, y * scale_m],
        scale_m,
    }
}

/// Linearises one pose.
pub fn linear(setup: &Setup, unknowns: &Unknowns, values: &[f64], pose: &TeethPose) -> Linear {
    let out = outputs(setup, unknowns, values, pose);
    let p = out.p_m;
    let angle = Angle::of_rad(theta(&p, setup.span_m));
    let at = unknowns.mounting();
    let (height_m, lever_m, place_m) = (
        values[at],
        [values[at + 1], values[at + 2]],
        [values[at + 3], values[at + 4]],
    );
    let moved = displacement(setup, unknowns, values, pose.deflection);
    let seen = beacon(middle(&p), moved.c_m, lever_m, place_m, &angle);
    let turned = seen.turned;
    let g_m = [parity(&p), seen.g[0], seen.g[1]];
    let rows = by_outputs(seen.by_theta, setup.span_m);
    let by_outputs: [[f64; 3]; SEGMENTS] = std::array::from_fn(|i| rows.map(|row| row[i]));
    let mut derivatives = Vec::with_capacity(256);
    for (by_output, list) in by_outputs.iter().zip(&out.by) {
        derivatives.extend(
            list.iter()
                .map(|(index, d)| (*index, by_output.map(|b| b * d))),
        );
    }
    let of_beacon = |[x, y]: [f64; 2]| [0.0, x, y];
    let [by_lever_x, by_lever_y] = angle.by_lever();
    derivatives.extend([
        (at, of_beacon(turned.map(|t| t / height_m))),
        (at + 1, of_beacon(by_lever_x)),
        (at + 2, of_beacon(by_lever_y)),
        (at + 3, of_beacon([1.0, 0.0])),
        (at + 4, of_beacon([0.0, 1.0])),
    ]);
    let turn = |x: f64, y: f64| of_beacon(angle.turn([x, y]).map(|t| moved.scale_m * t));
    let [u, v] = pose.deflection;
    derivatives.push((unknowns.misalignment(), turn(u, -v)));
    derivatives.push((unknowns.misalignment() + 1, turn(-v, u)));
    for (k, (n, m)) in unknowns.powers.iter().enumerate() {
        derivatives.push((unknowns.bend(0) + k, turn(u.powi(*n) * v.powi(*m), 0.0)));
        derivatives.push((unknowns.bend(1) + k, turn(0.0, v.powi(*n) * u.powi(*m))));
    }
    Linear {
        g_m,
        by: derivatives,
        by_outputs,
    }
}

impl Linear {
    /// Share of the segments' variance in g_x.
    pub fn segment_share_of_x(&self) -> f64 {
        self.by_outputs.iter().map(|b| b[1] * b[1]).sum()
    }

    /// Inverse of the Cholesky factor of the constraints' covariance.
    pub fn whitening(&self, noise: &Noise) -> Matrix3<f64> {
        let mut covariance = Matrix3::zeros();
        for b in &self.by_outputs {
            covariance += Matrix3::from_fn(|i, j| b[i] * b[j]) * noise.segment_m.powi(2);
        }
        covariance[(1, 1)] += noise.displacement_m.powi(2);
        covariance[(2, 2)] += noise.displacement_m.powi(2);
        // Positive definite: g_p has segments alone, the others each their own displacement.
        let factor = covariance.cholesky().map(|c| c.l());
        factor
            .and_then(|l| l.try_inverse())
            .unwrap_or_else(Matrix3::identity)
    }
}
