//! The baseline: equation (3) in each segment, equations (10) and (11) for the coordination sensor.

use crate::data::observations::Observations;
use courier_signal::equations::{
    Angle, OWN_COEFFICIENTS, OWN_ORDERS, beacon, own_error, own_error_by_phase, own_functions,
};
use effects::sensor::Regressor;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Orders of the own tooth phase in equation (3).
pub const ORDERS: [usize; 4] = {
    let [a, b, c, d] = OWN_ORDERS;
    [a as usize, b as usize, c as usize, d as usize]
};
/// Prior size of a harmonic of equation (3), rms m: ten times what is common, so it hardly binds.
const HARMONIC_M: f64 = 30.0e-6;
/// Prior size of an offset k_i,0, m. It ties the angle between the two sensors (equation 11 does so only weakly): 10 µm over the
/// span of 9.7 mm are a milliradian, as the paper's angles are off by (0.4 to 1.4 mrad).
const OFFSET_M: f64 = 10.0e-6;
/// Prior size of what is free, m: three hundred pitches, so that it holds nothing.
const FREE_M: f64 = 0.3;

/// Parameters of equations (3), (10) and (11). `k[segment]` is k_i,0 to k_i,8, metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Equation (3)'s k, m.
    pub k_m: [[f64; OWN_COEFFICIENTS]; 4],
    /// What is left in g_p of the tooth counts' arbitrary zeros, m.
    pub parity_offset_m: f64,
    /// Height h, m.
    pub height_m: f64,
    /// Lever arms l_x, l_y, m.
    pub lever_m: [f64; 2],
    /// Offsets o'_x, o'_y, m: arbitrary zeros, refitted on each recording.
    pub origin_m: [f64; 2],
}

/// Which of the parameters a recording can speak about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Segments that were recorded.
    pub segments: [bool; 4],
    /// Equations (10) and (11) are in use.
    pub beacon: bool,
    /// Residuals are those of single segments against a reference.
    pub reference: bool,
}

impl Baseline {
    /// Nominal geometry, nothing calibrated.
    pub fn nominal(observations: &Observations) -> Self {
        let [height_m, x, y] = observations.coordination_m;
        Self {
            height_m,
            lever_m: [x, y],
            ..Self::default()
        }
    }

    /// Error e of equation (3) and its slope de/dp at an unmodified output.
    pub fn error_m(&self, segment: usize, unmodified_m: f64, pitch_m: f64) -> (f64, f64) {
        let k = &self.k_m[segment];
        let f = TAU / pitch_m;
        let functions = own_functions((f * unmodified_m).sin_cos().into());
        (
            own_error(k, &functions),
            f * own_error_by_phase(k, &functions),
        )
    }

    /// Calibrated position, m, and the factor by which noise grows.
    pub fn calibrated(&self, segment: usize, unmodified_m: f64, pitch_m: f64) -> (f64, f64) {
        let (error, slope) = self.error_m(segment, unmodified_m, pitch_m);
        (unmodified_m + error, 1.0 + slope)
    }

    /// The unmodified output that calibrates to `position_m`: fixed point, to 1e-15 m for slopes below one half.
    pub fn unmodified(&self, segment: usize, position_m: f64, pitch_m: f64) -> f64 {
        let mut raw = position_m;
        for _ in 0..40 {
            let (error, slope) = self.error_m(segment, raw, pitch_m);
            let step = (raw + error - position_m) / (1.0 + slope).max(0.3);
            raw -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        raw
    }

    /// Equation (11) with calibrated segments: `(g_x, g_y)`, m, and their derivatives by theta.
    pub fn beacon_residual(
        &self,
        centre_m: [f64; 2],
        theta_rad: f64,
        tan_psi: [f64; 2],
    ) -> ([f64; 2], [f64; 2]) {
        let place_m = [0, 1].map(|axis| self.origin_m[axis] + self.lever_m[axis]);
        let seen = beacon(
            centre_m,
            tan_psi.map(|t| t * self.height_m),
            self.lever_m,
            place_m,
            &Angle::of_rad(theta_rad),
        );
        (seen.g, seen.by_theta)
    }

    /// The parameters as regressors, in the order of [`Baseline::add`], and their present values.
    pub fn regressors(&self, scope: Scope) -> (Vec<Regressor>, Vec<f64>) {
        let mut list = Vec::new();
        let mut values = Vec::new();
        for segment in (0..4).filter(|s| scope.segments[*s]) {
            let free = if scope.reference { FREE_M } else { OFFSET_M };
            list.push(Regressor::reading(
                format!("offset, segment {}", segment + 1),
                "m",
                free,
                segment,
                |_| 1.0,
            ));
            for order in ORDERS {
                let name = |part| format!("order {order} {part}, segment {}", segment + 1);
                list.push(Regressor::reading(
                    name("sine"),
                    "m",
                    HARMONIC_M,
                    segment,
                    move |m| m.raw[segment][order].0,
                ));
                list.push(Regressor::reading(
                    name("cosine"),
                    "m",
                    HARMONIC_M,
                    segment,
                    move |m| m.raw[segment][order].1,
                ));
            }
            values.extend(self.k_m[segment]);
        }
        if !scope.reference {
            list.push(Regressor::channel("offset of g_p", "m", FREE_M, 0, |_| 1.0));
            values.push(self.parity_offset_m);
        }
        if scope.beacon {
            list.extend(beacon_regressors());
            values.extend([
                self.height_m,
                self.lever_m[0],
                self.lever_m[1],
                self.origin_m[0],
                self.origin_m[1],
            ]);
        }
        (list, values)
    }

    /// Adds a step, in the order of [`Baseline::regressors`].
    pub fn add(&mut self, scope: Scope, step: &[f64]) {
        let mut at = step.iter().copied();
        let mut next = || at.next().unwrap_or(0.0);
        for segment in (0..4).filter(|s| scope.segments[*s]) {
            self.k_m[segment].iter_mut().for_each(|k| *k += next());
        }
        if !scope.reference {
            self.parity_offset_m += next();
        }
        if scope.beacon {
            self.height_m += next();
            self.lever_m.iter_mut().for_each(|l| *l += next());
            self.origin_m.iter_mut().for_each(|o| *o += next());
        }
    }
}

fn beacon_regressors() -> Vec<Regressor> {
    use effects::sensor::Covariates;
    let both = |name: &str, add: fn(&Covariates) -> [f64; 2]| {
        Regressor::channels(name, "m", FREE_M, move |m, out| {
            let [x, y] = add(m);
            out[1] += x;
            out[2] += y;
        })
    };
    vec![
        both("height h", |m| {
            Angle::of_rad(m.steady_theta_rad).turn(m.steady_tan_psi)
        }),
        // The origin o' is kept, and with it not the beacon's place at angle zero: that goes with the lever.
        both("lever l_x", |m| {
            Angle::of_rad(m.steady_theta_rad).turn([1.0, 0.0])
        }),
        both("lever l_y", |m| {
            Angle::of_rad(m.steady_theta_rad).turn([0.0, 1.0])
        }),
        both("origin o'_x", |_| [1.0, 0.0]),
        both("origin o'_y", |_| [0.0, 1.0]),
    ]
}
