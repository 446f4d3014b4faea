//! g_p, g_x and g_y of a pose (equations 5, 10, 11), their derivatives by the unknowns, and their covariance.

use super::model::{Derivatives, outputs};
use super::pose::{Noise, Setup, TeethPose};
use super::unknowns::{DEGREE, Unknowns};
use courier_sensor::equations::{Angle, beacon, by_outputs, middle, parity, theta};
use courier_sensor::frame::SEGMENTS;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// One pose linearised.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Calibrated outputs, metres.
    pub outputs_m: [f64; SEGMENTS],
    /// g_p, g_x, g_y, metres.
    pub g_m: [f64; 3],
    /// `(unknown, derivatives of the three)`.
    pub by: Vec<(usize, [f64; 3])>,
    /// Derivatives by the calibrated outputs, `[segment][constraint]`: by these a pose is whitened.
    pub by_outputs: [[f64; 3]; SEGMENTS],
    /// Derivatives by the raw outputs, in which the noise is: equation (3) and the waves, whose slopes reach a quarter, stretch it from place to place.
    /// Those of fields are a hundred times smaller and are left out.
    pub by_raw: [[f64; 3]; SEGMENTS],
}

/// Displacement of the beacon in the sensor's frame: raw deflection to metres.
struct Displacement {
    c_m: [f64; 2],
    scale_m: f64,
}

/// Powers of a deflection's two parts, from the zeroth.
type Powers = [[f64; DEGREE as usize + 1]; 2];

fn displacement(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    [u, v]: [f64; 2],
    [of_u, of_v]: &Powers,
) -> Displacement {
    let (gain, turn) = (
        values[unknowns.misalignment()],
        values[unknowns.misalignment() + 1],
    );
    let bend = |axis: usize, own: &[f64], other: &[f64]| -> f64 {
        let coefficients = &values[unknowns.bend(axis)..unknowns.bend(axis + 1)];
        unknowns
            .powers
            .iter()
            .zip(coefficients)
            .map(|((n, m), k)| k * own[*n as usize] * other[*m as usize])
            .sum()
    };
    let scale_m = values[unknowns.mounting()] * setup.tan_full_scale;
    let x = u + gain * u - turn * v + bend(0, of_u, of_v);
    let y = v - gain * v + turn * u + bend(1, of_v, of_u);
    Displacement {
        c_m: [x * scale_m, y * scale_m],
        scale_m,
    }
}

/// A pose at some values of the unknowns, before the derivatives by these.
struct AtPose {
    outputs_m: [f64; SEGMENTS],
    g_m: [f64; 3],
    by_outputs: [[f64; 3]; SEGMENTS],
    /// The same by the outputs before the waves: what moves one of these moves the waves as well.
    through: [[f64; 3]; SEGMENTS],
    by_raw: [[f64; 3]; SEGMENTS],
    angle: Angle<f64>,
    /// The beacon as it is seen, turned, and how it is scaled.
    turned: [f64; 2],
    scale_m: f64,
    powers: Powers,
}

impl AtPose {
    /// Derivatives of the outputs are added to these lists, where there are some.
    fn new(
        setup: &Setup,
        unknowns: &Unknowns,
        values: &[f64],
        pose: &TeethPose,
        derivatives: Option<&mut Derivatives>,
    ) -> Self {
        let out = outputs(setup, unknowns, values, pose, derivatives);
        let p = out.p_m;
        let angle = Angle::of_rad(theta(&p, setup.span_m));
        let at = unknowns.mounting();
        let (lever_m, place_m) = (
            [values[at + 1], values[at + 2]],
            [values[at + 3], values[at + 4]],
        );
        let of_part = |x: f64| std::array::from_fn(|degree| x.powi(degree as i32));
        let powers = pose.deflection.map(of_part);
        let moved = displacement(setup, unknowns, values, pose.deflection, &powers);
        let seen = beacon(middle(&p), moved.c_m, lever_m, place_m, &angle);
        let rows = by_outputs(seen.by_theta, setup.span_m);
        let by_outputs: [[f64; 3]; SEGMENTS] = std::array::from_fn(|i| rows.map(|row| row[i]));
        let through: [[f64; 3]; SEGMENTS] = std::array::from_fn(|j| {
            std::array::from_fn(|k| {
                let by_waves = (0..SEGMENTS).map(|i| by_outputs[i][k] * out.waves_by_outputs[i][j]);
                by_outputs[j][k] + by_waves.sum::<f64>()
            })
        });
        Self {
            outputs_m: p,
            g_m: [parity(&p), seen.g[0], seen.g[1]],
            by_outputs,
            through,
            by_raw: std::array::from_fn(|j| through[j].map(|by| by * out.by_raw[j])),
            angle,
            turned: seen.turned,
            scale_m: moved.scale_m,
            powers,
        }
    }
}

/// [`Linear::g_m`] of a pose alone.
#[must_use]
pub fn misclosures(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    pose: &TeethPose,
) -> [f64; 3] {
    AtPose::new(setup, unknowns, values, pose, None).g_m
}

/// [`Linear::by_raw`] of a pose alone.
#[must_use]
pub fn by_raw_outputs(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    pose: &TeethPose,
) -> [[f64; 3]; SEGMENTS] {
    AtPose::new(setup, unknowns, values, pose, None).by_raw
}

/// Linearises one pose at some values of the unknowns.
#[must_use]
pub fn linear(setup: &Setup, unknowns: &Unknowns, values: &[f64], pose: &TeethPose) -> Linear {
    let mut by = Derivatives::default();
    let seen = AtPose::new(setup, unknowns, values, pose, Some(&mut by));
    let lists = by.of_waves.iter().chain(&by.before_waves);
    let of_outputs: usize = lists.map(Vec::len).sum();
    let of_displacement = 7 + 2 * unknowns.powers.len();
    let mut derivatives = Vec::with_capacity(of_outputs + of_displacement);
    for (by_output, list) in seen.by_outputs.iter().zip(&by.of_waves) {
        let each = list.iter();
        derivatives.extend(each.map(|(index, d)| (*index, by_output.map(|b| b * d))));
    }
    for (by_output, list) in seen.through.iter().zip(&by.before_waves) {
        let each = list.iter();
        derivatives.extend(each.map(|(index, d)| (*index, by_output.map(|b| b * d))));
    }
    let at = unknowns.mounting();
    let of_beacon = |[x, y]: [f64; 2]| [0.0, x, y];
    let [by_lever_x, by_lever_y] = seen.angle.by_lever();
    derivatives.extend([
        (at, of_beacon(seen.turned.map(|t| t / values[at]))),
        (at + 1, of_beacon(by_lever_x)),
        (at + 2, of_beacon(by_lever_y)),
        (at + 3, of_beacon([1.0, 0.0])),
        (at + 4, of_beacon([0.0, 1.0])),
    ]);
    let turn = |x: f64, y: f64| of_beacon(seen.angle.turn([x, y]).map(|t| seen.scale_m * t));
    let [u, v] = pose.deflection;
    derivatives.push((unknowns.misalignment(), turn(u, -v)));
    derivatives.push((unknowns.misalignment() + 1, turn(-v, u)));
    let [of_u, of_v] = &seen.powers;
    for (k, (n, m)) in unknowns.powers.iter().enumerate() {
        let (n, m) = (*n as usize, *m as usize);
        derivatives.push((unknowns.bend(0) + k, turn(of_u[n] * of_v[m], 0.0)));
        derivatives.push((unknowns.bend(1) + k, turn(0.0, of_v[n] * of_u[m])));
    }
    Linear {
        outputs_m: seen.outputs_m,
        g_m: seen.g_m,
        by: derivatives,
        by_outputs: seen.by_outputs,
        by_raw: seen.by_raw,
    }
}

/// How much linearised poses leave of their constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// Robust size of g_p, m.
    pub parity_m: f64,
    /// And of g_x, m.
    pub x_m: f64,
    /// Share of the segments' variance in g_p.
    pub segment_share_of_parity: f64,
    /// Share of the segments' variance in g_x.
    pub segment_share_of_x: f64,
}

impl Left {
    /// Of one pose or more.
    #[must_use]
    pub fn of(lines: &[Linear]) -> Self {
        let robust = |k: usize| {
            let mut sizes: Vec<f64> = lines.iter().map(|line| line.g_m[k].abs()).collect();
            let middle = sizes.len() / 2;
            // Gaussian deviation over median absolute value.
            1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        let share = |k: usize| {
            let shares = lines.iter().map(|line| line.segment_share(k));
            shares.sum::<f64>() / lines.len() as f64
        };
        Self {
            parity_m: robust(0),
            x_m: robust(1),
            segment_share_of_parity: share(0),
            segment_share_of_x: share(1),
        }
    }

    /// The noise that shows in it, not below the stated: segments by g_p, displacements by what of g_x these leave. `spent` is the share of
    /// the poses' equations that the unknowns took, 0 to below 1.
    #[must_use]
    pub fn noise(&self, stated: &Noise, spent: f64) -> Noise {
        let [parity_m, x_m] = [self.parity_m, self.x_m].map(|m| m / (1.0 - spent).sqrt());
        let segment_m = (parity_m / self.segment_share_of_parity.sqrt()).max(stated.segment_m);
        let left = x_m.powi(2) - self.segment_share_of_x * segment_m.powi(2);
        Noise {
            segment_m,
            displacement_m: left.max(0.0).sqrt().max(stated.displacement_m),
        }
    }
}

/// Longer whitened misclosures count less (Huber 1964).
const FULL_WEIGHT: f64 = 4.0;

impl Linear {
    /// Share of the segments' variance in a constraint.
    fn segment_share(&self, constraint: usize) -> f64 {
        self.by_outputs.iter().map(|b| b[constraint].powi(2)).sum()
    }

    /// The whitened misclosures, what whitens derivatives, and the root of the pose's weight.
    #[must_use]
    pub fn whitened(&self, noise: &Noise) -> (Vector3<f64>, Matrix3<f64>, f64) {
        let whitening = self.whitening(noise);
        let misclosure = whitening * Vector3::from(self.g_m);
        let length = misclosure.norm();
        let root = if length > FULL_WEIGHT {
            (FULL_WEIGHT / length).sqrt()
        } else {
            1.0
        };
        (misclosure, whitening, root)
    }

    /// What the pose adds to the sum that a fit makes small: the square of its whitened misclosure, and beyond four deviations in proportion to it
    /// (Huber 1964).
    #[must_use]
    pub fn squares(&self, noise: &Noise) -> f64 {
        let length = self.whitened(noise).0.norm();
        if length > FULL_WEIGHT {
            FULL_WEIGHT * (2.0 * length - FULL_WEIGHT)
        } else {
            length * length
        }
    }

    /// Inverse of the Cholesky factor of the constraints' covariance.
    #[must_use]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rulings::Rulings;
    use courier_sensor::teeth::Grid;

    /// The derivatives by the raw outputs against differences, where equations (3) and (9) act, and that they are others than those by the
    /// calibrated outputs. They take the places of (9)'s waves as they are, though these waves move them: that leaves out the square of the waves'
    /// slope, which is some 0.02 for waves of 1 µm.
    #[test]
    fn slopes_by_raw_outputs_are_those_of_the_constraints() {
        /// Step of the differences, m. Derived from the highest order: at 37,000 rad a metre a slope over two such steps is off by
        /// (37,000 · 1e-8)² / 6 of itself, 2e-8, and rounding makes 1e-11.
        const STEP_M: f64 = 1.0e-8;
        let setup = Setup {
            pitch_m: 1.016e-3,
            span_m: 9.7e-3,
            lateral_m: 4.0e-3,
            height_m: 8.0e-3,
            lever_m: [1.0e-3, -0.5e-3],
            tan_full_scale: 0.3,
            rulings: Rulings::default(),
            segment_noise_m: 1.0e-7,
            displacement_noise_m: 1.0e-6,
        };
        let grid = Grid {
            first_teeth: [-2; 2],
            nodes: [5; 2],
        };
        let unknowns = Unknowns::new([grid; 2]);
        let mut values = unknowns.start(&setup);
        for at in 0..unknowns.parity() {
            values[at] = 4.0e-6 * (1.7 * at as f64).sin();
        }
        for at in unknowns.wave(0, 0)..unknowns.field(0) {
            values[at] = 1.0e-6 * (1.7 * at as f64).sin();
        }
        let at = |moved: Option<(usize, f64)>| {
            let mut pose = TeethPose {
                outputs_m: [0.31e-3, -0.22e-3, 0.36e-3, -0.27e-3],
                deflection: [0.02, -0.03],
            };
            if let Some((segment, by_m)) = moved {
                pose.outputs_m[segment] += by_m;
            }
            linear(&setup, &unknowns, &values, &pose)
        };
        let here = at(None);
        let mut stretched = 0.0_f64;
        for segment in 0..SEGMENTS {
            let [above, below] = [STEP_M, -STEP_M].map(|by| at(Some((segment, by))).g_m);
            for k in 0..3 {
                let wanted = (above[k] - below[k]) / (2.0 * STEP_M);
                let found = here.by_raw[segment][k];
                assert!(
                    (found - wanted).abs() < 1e-3,
                    "{segment} {k}: {found} {wanted}"
                );
                stretched = stretched.max((found - here.by_outputs[segment][k]).abs());
            }
        }
        assert!(stretched > 0.05, "{stretched}");
    }
}
