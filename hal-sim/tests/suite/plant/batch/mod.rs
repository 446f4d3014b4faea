//! The paper's own method in f64, from the sensor's side: counts and tooth counts to positions, batch least squares.
//!
//! Written from the equations alone; nothing of the plant is used but the geometry's numbers.

pub mod rows;

use effects::plant::Geometry;
use hal_sim::record::Observation;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Own orders of equation (3).
const ORDERS: [f64; 4] = [1.0, 2.0, 4.0, 6.0];

/// Signs of the segments in the parity.
pub const SIGNS: [f64; 4] = [1.0, -1.0, -1.0, 1.0];

/// Parameters of a segment: eight of equation (3) without its offset, two of equation (9).
pub const PER_SEGMENT: usize = 10;

/// What the sensors read at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Unmodified outputs, metres.
    pub p: [f64; 4],
    /// tan psi.
    pub tan_psi: [f64; 2],
    /// Reference x, y, theta.
    pub reference: [f64; 3],
}

/// Counts to unmodified outputs and angles.
pub fn reading(observation: &Observation, nominal: &Geometry) -> Reading {
    let sample = &observation.sample;
    let p = std::array::from_fn(|s| {
        let [sine, cosine] = sample.quadrature[s].map(f64::from);
        (f64::from(observation.teeth[s]) + sine.atan2(cosine) / TAU) * nominal.pitch_m
    });
    let [a, b, c, d] = sample.electrodes.map(f64::from);
    let ratio = |a: f64, b: f64| nominal.tan_full_scale * (a - b) / (a + b);
    let reference = observation.reference;
    Reading {
        p,
        tan_psi: [ratio(a, b), ratio(c, d)],
        reference: [reference.x_m, reference.y_m, reference.theta_rad],
    }
}

/// Platen parameters: `[segment][sine and cosine of orders 1, 2, 4, 6, then of the lateral phase]`, and the offsets that
/// the parity and the mean angle see.
#[derive(Clone, Debug, PartialEq)]
pub struct Platen {
    /// Metres.
    pub k: [[f64; PER_SEGMENT]; 4],
    /// Added to the parity, metres (the four offsets' one combination).
    pub parity_offset: f64,
    /// Added to the mean angle, radians.
    pub angle_offset: f64,
}

impl Platen {
    /// Uncalibrated.
    pub const NONE: Self = Self {
        k: [[0.0; PER_SEGMENT]; 4],
        parity_offset: 0.0,
        angle_offset: 0.0,
    };
}

/// Regressors of one segment, equations (3) and (9).
fn regressors(reading: &Reading, segment: usize, geometry: &Geometry) -> [f64; PER_SEGMENT] {
    let f = TAU / geometry.pitch_m;
    let p = &reading.p;
    let theta = (p[0] - p[2] + p[1] - p[3]) / (2.0 * geometry.span_m);
    let (x, y, side) = (
        0.5 * (p[0] + p[2]),
        0.5 * (p[1] + p[3]),
        geometry.lateral_m * theta,
    );
    let lateral = [y - side, x + side, y + side, x - side][segment];
    let mut row = [0.0; PER_SEGMENT];
    for (i, order) in ORDERS.into_iter().enumerate() {
        (row[2 * i], row[2 * i + 1]) = (order * f * p[segment]).sin_cos();
    }
    (row[8], row[9]) = (f * lateral).sin_cos();
    row
}

/// Calibrated outputs.
pub fn calibrated(reading: &Reading, platen: &Platen, geometry: &Geometry) -> [f64; 4] {
    std::array::from_fn(|s| {
        let row = regressors(reading, s, geometry);
        let error: f64 = row.iter().zip(&platen.k[s]).map(|(r, k)| r * k).sum();
        let angle = 0.5 * platen.angle_offset * geometry.span_m * if s < 2 { 1.0 } else { -1.0 };
        reading.p[s] + error + 0.25 * SIGNS[s] * platen.parity_offset + angle
    })
}

/// Pose and parity of calibrated outputs: x, y, theta_x, theta_y, g_p.
pub fn pose(p: &[f64; 4], geometry: &Geometry) -> [f64; 5] {
    let (tx, ty) = (
        (p[0] - p[2]) / geometry.span_m,
        (p[1] - p[3]) / geometry.span_m,
    );
    [
        0.5 * (p[0] + p[2]),
        0.5 * (p[1] + p[3]),
        tx,
        ty,
        p[0] - p[1] - p[2] + p[3],
    ]
}

/// Standard deviation: the paper's "error magnitude".
pub fn deviation(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Equation (8): fits equation (3) to the parity. Returns the platen and the condition number of Gamma, offsets merged.
pub fn fit_parity(readings: &[Reading], geometry: &Geometry) -> (Platen, f64) {
    let mut gamma = DMatrix::zeros(readings.len(), 33);
    let mut parity = DVector::zeros(readings.len());
    for (j, reading) in readings.iter().enumerate() {
        parity[j] = pose(&reading.p, geometry)[4];
        gamma[(j, 0)] = 1.0;
        for s in 0..4 {
            let row = regressors(reading, s, geometry);
            (0..8).for_each(|i| gamma[(j, 1 + 8 * s + i)] = SIGNS[s] * row[i]);
        }
    }
    let svd = gamma.svd(true, true);
    let condition = svd.singular_values.max() / svd.singular_values.min();
    let k = svd
        .solve(&-parity, 1e-12)
        .expect("both factors were computed");
    let mut platen = Platen {
        parity_offset: k[0],
        ..Platen::NONE
    };
    for s in 0..4 {
        (0..8).for_each(|i| platen.k[s][i] = k[1 + 8 * s + i]);
    }
    (platen, condition)
}

/// Mounting of the coordination sensor: h, l_x, l_y, o'_x, o'_y.
pub type Mount = [f64; 5];

/// Equation (11): g_x and g_y.
pub fn constraint(
    reading: &Reading,
    platen: &Platen,
    mount: &Mount,
    geometry: &Geometry,
) -> [f64; 2] {
    let [x, y, tx, ty, _] = pose(&calibrated(reading, platen, geometry), geometry);
    let (sine, cosine) = (0.5 * (tx + ty)).sin_cos();
    let [h, lx, ly, ox, oy] = *mount;
    let (cx, cy) = (h * reading.tan_psi[0] + lx, h * reading.tan_psi[1] + ly);
    [
        cosine * cx - sine * cy + ox - x,
        sine * cx + cosine * cy + oy - y,
    ]
}

/// Gauss-Newton over the mount alone (J'), platen fixed.
pub fn fit_mount(readings: &[Reading], platen: &Platen, geometry: &Geometry) -> Mount {
    let r = &readings[0];
    let mut mount = [
        geometry.height_m,
        geometry.lever_m[0],
        geometry.lever_m[1],
        r.p[0],
        r.p[1],
    ];
    mount[3] -= mount[1];
    mount[4] -= mount[2];
    gauss_newton(&mut mount, |mount| {
        readings
            .iter()
            .flat_map(|r| constraint(r, platen, mount.try_into().expect("five"), geometry))
            .collect()
    });
    mount
}

/// Gauss-Newton over everything, J of equation (11) with equal weights and equation (9).
pub fn fit_joint(
    readings: &[Reading],
    platen: &Platen,
    mount: &Mount,
    geometry: &Geometry,
) -> (Platen, Mount) {
    let mut parameters: Vec<f64> = platen.k.iter().flatten().copied().collect();
    parameters.extend([platen.parity_offset, platen.angle_offset * geometry.span_m]);
    parameters.extend(mount);
    let unpack = |v: &[f64]| {
        let k = std::array::from_fn(|s| std::array::from_fn(|i| v[PER_SEGMENT * s + i]));
        let platen = Platen {
            k,
            parity_offset: v[40],
            angle_offset: v[41] / geometry.span_m,
        };
        (platen, <Mount>::try_from(&v[42..47]).expect("five"))
    };
    gauss_newton(&mut parameters, |v| {
        let (platen, mount) = unpack(v);
        let parity = |r: &Reading| pose(&calibrated(r, &platen, geometry), geometry)[4];
        let row = |r: &Reading| {
            let [gx, gy] = constraint(r, &platen, &mount, geometry);
            [gx, gy, parity(r)]
        };
        readings.iter().flat_map(row).collect()
    });
    unpack(&parameters)
}

/// Three steps of Gauss-Newton with a numeric Jacobian (the problem is nearly linear); QR of the scaled columns.
fn gauss_newton(parameters: &mut [f64], residuals: impl Fn(&[f64]) -> Vec<f64>) {
    let step = 1.0e-7;
    for _ in 0..3 {
        let now = DVector::from_vec(residuals(parameters));
        let mut jacobian = DMatrix::zeros(now.len(), parameters.len());
        let mut moved = parameters.to_vec();
        for i in 0..parameters.len() {
            moved[i] += step;
            let column = (DVector::from_vec(residuals(&moved)) - &now) / step;
            jacobian.set_column(i, &column);
            moved[i] = parameters[i];
        }
        let scale: Vec<f64> = jacobian
            .column_iter()
            .map(|c| c.norm().max(1e-30))
            .collect();
        scale
            .iter()
            .enumerate()
            .for_each(|(i, s)| jacobian.column_mut(i).scale_mut(1.0 / s));
        // Normal equations in f64 of unit columns: their condition, about 1e6, leaves ten digits.
        let normal =
            jacobian.transpose() * &jacobian + DMatrix::identity(scale.len(), scale.len()) * 1e-12;
        let right = jacobian.transpose() * now;
        let change = normal.cholesky().expect("damped").solve(&right);
        parameters
            .iter_mut()
            .zip(&scale)
            .enumerate()
            .for_each(|(i, (p, s))| *p -= change[i] / s);
    }
}
