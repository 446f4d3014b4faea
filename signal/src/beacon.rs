//! Pose relative to the beacon: by the coordination sensor, by the platen sensor, and both by their covariance.
//!
//! Equations (10) and (11) with g_x = g_y = 0: `p - o' = R(theta) (c + l)`, c = h tan psi. The fusion is the linear
//! minimum-variance estimate of x, y and theta from the platen's pose and the two displacements, linearised at the platen's
//! angle; its innovation covariance `q I + P_theta w w'` is inverted in closed form (Sherman and Morrison 1950).

use crate::diode::{self, DiodeErrors};
use crate::frame::{BeaconPose, Coordinate, Pose, RelativePose};
use crate::geometry::Geometry;
use crate::math;
use serde::{Deserialize, Serialize};

/// What a joint calibration found beside the geometry, and how far each sensor is to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeaconSettings {
    /// The beacon's place o' in the platen sensor's coordinates: whole teeth of x and y.
    pub origin_teeth: [i32; 2],
    /// The rest of it, metres.
    pub origin_m: [f32; 2],
    /// The coordination sensor's own errors.
    pub sensor: DiodeErrors,
    /// Standard deviation of a segment's calibrated output, metres.
    pub segment_sd_m: f32,
    /// Standard deviation of a displacement under the beacon, metres.
    pub displacement_sd_m: f32,
}

/// [`BeaconSettings`] as the interrupt applies them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompiledBeaconPose {
    origin_teeth: [i32; 2],
    origin_turns: [f32; 2],
    pitch_m: f32,
    /// Height times full scale: from a deflection to a displacement.
    scale_m: f32,
    per_full_scale: f32,
    sensor: DiodeErrors,
    lever_m: [f32; 2],
    /// Variance of the innovation apart from the angle's part, over that of the angle, m².
    spread_m2: f32,
    /// Share of an innovation that is the platen's.
    platen_share: f32,
}

impl BeaconSettings {
    /// Machine form. A mean of two segments has half a segment's variance; the angle's is that of one over the span.
    #[inline] // built with the image, for size
    pub(crate) fn compile(&self, geometry: &Geometry) -> CompiledBeaconPose {
        let segment = self.segment_sd_m * self.segment_sd_m;
        let (position, angle) = (0.5 * segment, segment / (geometry.span_m * geometry.span_m));
        let sum = position + self.displacement_sd_m * self.displacement_sd_m;
        CompiledBeaconPose {
            origin_teeth: self.origin_teeth,
            origin_turns: self.origin_m.map(|m| m / geometry.pitch_m),
            pitch_m: geometry.pitch_m,
            scale_m: geometry.height_m * geometry.tan_full_scale,
            per_full_scale: 1.0 / geometry.tan_full_scale,
            sensor: self.sensor,
            lever_m: geometry.lever_m,
            spread_m2: sum / angle,
            platen_share: position / sum,
        }
    }
}

impl CompiledBeaconPose {
    /// For a frame in which the beacon is seen. About 300 cycles.
    #[inline(never)]
    pub fn pose(&self, pose: &Pose, tan_psi: [f32; 2]) -> BeaconPose {
        let from_origin = |p: Coordinate, axis: usize| {
            let teeth = p.teeth.wrapping_sub(self.origin_teeth[axis]) as f32;
            (teeth + (p.fraction_turns - self.origin_turns[axis])) * self.pitch_m
        };
        let platen = RelativePose {
            x_m: from_origin(pose.x, 0),
            y_m: from_origin(pose.y, 1),
            theta_rad: pose.theta_rad,
        };
        let (sine, cosine) =
            math::sincos_turns(pose.theta_rad * (0.5 * core::f32::consts::FRAC_1_PI));
        let deflection = tan_psi.map(|t| t * self.per_full_scale);
        let [u, v] = diode::corrected(deflection, &self.sensor);
        let a = self.scale_m * u + self.lever_m[0];
        let b = self.scale_m * v + self.lever_m[1];
        let sensor = RelativePose {
            x_m: cosine * a - sine * b,
            y_m: sine * a + cosine * b,
            theta_rad: pose.theta_rad,
        };
        BeaconPose {
            seen: true,
            sensor,
            platen,
            fused: self.fuse(&platen, &sensor),
        }
    }

    /// The innovation (u, v) is the sensor's position less the platen's; w = (y, -x) of the lever arm is how it turns.
    fn fuse(&self, platen: &RelativePose, sensor: &RelativePose) -> RelativePose {
        let (u, v) = (sensor.x_m - platen.x_m, sensor.y_m - platen.y_m);
        let (wx, wy) = (sensor.y_m, -sensor.x_m);
        let turn = (wx * u + wy * v) / (self.spread_m2 + wx * wx + wy * wy);
        RelativePose {
            x_m: platen.x_m + self.platen_share * (u - wx * turn),
            y_m: platen.y_m + self.platen_share * (v - wy * turn),
            theta_rad: platen.theta_rad + turn,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const SEGMENT_SD_M: f64 = 1.0e-6;
    const DISPLACEMENT_SD_M: f64 = 2.0e-6;
    const SETTINGS: BeaconSettings = BeaconSettings {
        origin_teeth: [40, -7],
        origin_m: [0.3e-3, -0.1e-3],
        sensor: [0.0; _],
        segment_sd_m: SEGMENT_SD_M as f32,
        displacement_sd_m: DISPLACEMENT_SD_M as f32,
    };

    fn coordinate(metres: f64) -> Coordinate {
        let turns = metres / f64::from(Geometry::PAPER.pitch_m);
        Coordinate {
            teeth: turns.round() as i32,
            fraction_turns: (turns - turns.round()) as f32,
        }
    }

    /// What the sensors say at a true pose relative to the beacon, with an error of each.
    fn readings([x, y, theta]: [f64; 3], error: [f64; 5]) -> (Pose, [f32; 2]) {
        let g = Geometry::PAPER;
        let origin = |k: usize| {
            f64::from(SETTINGS.origin_teeth[k]) * f64::from(g.pitch_m)
                + f64::from(SETTINGS.origin_m[k])
        };
        let pose = Pose {
            x: coordinate(x + origin(0) + error[0]),
            y: coordinate(y + origin(1) + error[1]),
            theta_rad: (theta + error[2]) as f32,
            ..Pose::default()
        };
        let (s, c) = theta.sin_cos();
        let displacement = [
            c * x + s * y - f64::from(g.lever_m[0]),
            c * y - s * x - f64::from(g.lever_m[1]),
        ];
        let tan = |k: usize| ((displacement[k] + error[3 + k]) / f64::from(g.height_m)) as f32;
        (pose, [tan(0), tan(1)])
    }

    fn difference(p: &RelativePose, truth: [f64; 3]) -> [f64; 3] {
        [
            f64::from(p.x_m) - truth[0],
            f64::from(p.y_m) - truth[1],
            f64::from(p.theta_rad) - truth[2],
        ]
    }

    #[test]
    fn without_noise_all_three_are_the_truth() {
        let beacon = SETTINGS.compile(&Geometry::PAPER);
        for truth in [
            [0.0901, 0.0049, 0.0],
            [0.0887, 0.0071, 0.026],
            [0.092, 0.003, -0.02],
        ] {
            let (pose, tan_psi) = readings(truth, [0.0; 5]);
            let seen = beacon.pose(&pose, tan_psi);
            for p in [&seen.platen, &seen.sensor, &seen.fused] {
                let [x, y, theta] = difference(p, truth);
                // f32 metres at 90 mm resolve 7 nm.
                assert!(
                    x.abs() < 30e-9 && y.abs() < 30e-9 && theta.abs() < 0.4e-6,
                    "{x:e} {y:e} {theta:e}"
                );
            }
        }
    }

    /// The fused pose's scatter against its own prediction, the minimum variance of the linear problem in f64.
    #[test]
    fn the_fused_scatter_is_the_predicted_one() {
        let beacon = SETTINGS.compile(&Geometry::PAPER);
        let truth = [0.0905, 0.0052, 0.004];
        let (position_var, angle_var) = (
            0.5 * SEGMENT_SD_M.powi(2),
            (SEGMENT_SD_M / f64::from(Geometry::PAPER.span_m)).powi(2),
        );
        let sd = [
            position_var.sqrt(),
            position_var.sqrt(),
            angle_var.sqrt(),
            DISPLACEMENT_SD_M,
            DISPLACEMENT_SD_M,
        ];
        let information = {
            // Rows of [x, y, theta]: the platen's three, then x - r_x(theta), y - r_y(theta).
            let rows = [
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [1.0, 0.0, truth[1]],
                [0.0, 1.0, -truth[0]],
            ];
            let mut sum = nalgebra::Matrix3::zeros();
            for (row, sd) in rows.iter().zip(sd) {
                let row = nalgebra::RowVector3::from(*row) / sd;
                sum += row.transpose() * row;
            }
            sum
        };
        let covariance = information.try_inverse().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let draws = 20_000;
        let mut square = [0.0; 3];
        for _ in 0..draws {
            let error = sd.map(|sd| {
                let n: f64 = StandardNormal.sample(&mut rng);
                sd * n
            });
            let (pose, tan_psi) = readings(truth, error);
            let off = difference(&beacon.pose(&pose, tan_psi).fused, truth);
            (0..3).for_each(|k| square[k] += off[k] * off[k] / f64::from(draws));
        }
        for k in 0..3 {
            let ratio = square[k] / covariance[(k, k)];
            // 1 ± 4 sqrt(2 / 20000)
            assert!((0.96..1.04).contains(&ratio), "{k}: {ratio}");
            assert!(k != 2 || covariance[(2, 2)] < 0.06 * angle_var);
        }
    }

    /// A diode's own errors are taken out of the deflection before the lever arm is added.
    #[test]
    fn the_sensors_own_errors_are_applied() {
        let mut settings = SETTINGS;
        settings.sensor = core::array::from_fn(|i| 0.01 * (i as f32 - 7.0));
        let beacon = settings.compile(&Geometry::PAPER);
        let (pose, tan_psi) = readings([0.0905, 0.0052, 0.01], [0.0; 5]);
        let full_scale = Geometry::PAPER.tan_full_scale;
        let bent = diode::corrected(tan_psi.map(|t| t / full_scale), &settings.sensor);
        let plain = SETTINGS
            .compile(&Geometry::PAPER)
            .pose(&pose, bent.map(|u| u * full_scale));
        let seen = beacon.pose(&pose, tan_psi);
        assert!((seen.sensor.x_m - plain.sensor.x_m).abs() < 20e-9);
        assert!((seen.sensor.y_m - plain.sensor.y_m).abs() < 20e-9);
        assert!((seen.sensor.x_m - seen.platen.x_m).abs() > 1e-6);
    }
}
