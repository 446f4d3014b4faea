//! The error of the position, as an interferometer would see it.

use core::f64::consts::TAU;
use courier_sensor::frame::{Coordinate, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{Basis, ErrorModel, Observation};
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::courier::Courier;
use hal_sim::spec::CourierSpec;
use nalgebra::{DMatrix, DVector};

/// Poses that are looked at: a root of the mean square is known to 2 %.
const POSES: usize = 1000;
/// Readings of each, whose mean is taken: what is asked of is the calibration, not one reading's noise.
const READINGS: usize = 16;

/// Segments' unmodified outputs at still poses all over 0.1 m of the platen and within ±0.5°, at one time.
pub struct Look {
    poses: Vec<(Pose, [Coordinate; SEGMENTS])>,
}

impl Look {
    pub fn new(spec: CourierSpec, time_s: f64, seed: u64) -> Self {
        let mut courier = Courier::new(spec, seed).expect("a sensor of unique phase");
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x100c);
        let poses = (0..POSES)
            .map(|_| {
                let mut within = |low: f64, high: f64| uniform(&mut rng, low, high);
                let pose = Pose::new(
                    within(0.0, 0.1),
                    within(0.0, 0.1),
                    within(-8.727e-3, 8.727e-3),
                );
                let mut sums = [[0.0; 2]; SEGMENTS];
                for _ in 0..READINGS {
                    let seen = courier.counts_at(&pose, time_s);
                    for (sum, pair) in sums.iter_mut().zip(seen.quadrature) {
                        sum[0] += f64::from(pair[0]);
                        sum[1] += f64::from(pair[1]);
                    }
                }
                let outputs = sums.map(|[sine, cosine]| Coordinate {
                    teeth: 0,
                    fraction_turns: (sine.atan2(cosine) / TAU) as f32,
                });
                (pose, outputs)
            })
            .collect();
        Self { poses }
    }

    /// Error of the position, metres rms along the worse axis, its mean aside: a calibration does not tell where zero is.
    pub fn error_m(&self, model: &ErrorModel) -> f64 {
        let [x, y] = self.errors_m(model);
        x.max(y)
    }

    /// The least of [`Look::error_m`] that any amounts of equation (3) leave at these very poses: by least squares, knowing the truth.
    pub fn least_m(&self) -> f64 {
        let none = ErrorModel::default();
        let axis = |axis: usize| {
            let functions = DMatrix::from_fn(self.poses.len(), 17, |i, j| {
                let segment = axis + 2 * (j / 8);
                let turns = f64::from(self.poses[i].1[segment % SEGMENTS].fraction_turns);
                let wave = TAU * [1.0, 2.0, 4.0, 6.0][j % 8 / 2] * turns;
                match (j, j % 2) {
                    (16, _) => 1.0,
                    (_, 0) => wave.sin(),
                    _ => wave.cos(),
                }
            });
            let errors = self.poses.iter().map(|pose| {
                let errors = error_m(&none, pose);
                0.5 * (errors[axis] + errors[axis + 2])
            });
            let errors = DVector::from_iterator(self.poses.len(), errors);
            let fit = functions.clone().svd(true, true).solve(&errors, 1.0e-12);
            let left = functions * fit.expect("poses at all phases") - errors;
            (left.norm_squared() / self.poses.len() as f64).sqrt()
        };
        axis(0).max(axis(1))
    }

    /// Root of the mean square along both axes.
    pub fn mean_m(&self, model: &ErrorModel) -> f64 {
        let [x, y] = self.errors_m(model);
        (0.5 * (x * x + y * y)).sqrt()
    }

    /// Amounts of equation (3) in each segment's error, sine and cosine of each order, beside which orders 3 and 5 are fitted too: metres.
    pub fn amounts_m(&self, model: &ErrorModel) -> [f64; 32] {
        let mut amounts = [0.0; 32];
        for (segment, amounts) in amounts.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let row = |i: usize| {
                let turns = f64::from(self.poses[i].1[segment].fraction_turns);
                [1.0, 2.0, 4.0, 6.0, 3.0, 5.0].map(|n| (TAU * n * turns).sin_cos())
            };
            let functions = DMatrix::from_fn(self.poses.len(), 13, |i, j| match j {
                12 => 1.0,
                j if j % 2 == 0 => row(i)[j / 2].0,
                j => row(i)[j / 2].1,
            });
            let errors = self.poses.iter().map(|pose| error_m(model, pose)[segment]);
            let errors = DVector::from_iterator(self.poses.len(), errors);
            let fit = functions.svd(true, true).solve(&errors, 1.0e-12);
            let fit = fit.expect("poses at all phases");
            amounts
                .iter_mut()
                .zip(fit.iter())
                .for_each(|(a, b)| *a = *b);
        }
        amounts
    }

    pub fn errors_m(&self, model: &ErrorModel) -> [f64; 2] {
        let mut sums = [[0.0; 2]; 2];
        for pose in &self.poses {
            let errors = error_m(model, pose);
            for (axis, [sum, square]) in sums.iter_mut().enumerate() {
                let error = 0.5 * (errors[axis] + errors[axis + 2]);
                *sum += error;
                *square += error * error;
            }
        }
        let count = self.poses.len() as f64;
        sums.map(|[sum, square]| (square / count - (sum / count).powi(2)).sqrt())
    }
}

/// Errors of all segments' calibrated outputs at a pose.
fn error_m(
    model: &ErrorModel,
    (pose, unmodified): &(Pose, [Coordinate; SEGMENTS]),
) -> [f64; SEGMENTS] {
    let geometry = Geometry::PAPER;
    let pitch_m = f64::from(geometry.pitch_m);
    let basis = Basis::new(
        &geometry,
        &Observation {
            unmodified: *unmodified,
            ..Observation::default()
        },
    );
    let arm_m = 0.5 * f64::from(geometry.span_m) * pose.theta_rad;
    core::array::from_fn(|s| {
        let place_m = [pose.x_m, pose.y_m][s % 2] + if s < 2 { arm_m } else { -arm_m };
        let output_m =
            pitch_m * f64::from(unmodified[s].fraction_turns) + f64::from(model.error_m(&basis, s));
        let off = (output_m - place_m) / pitch_m;
        pitch_m * (off - off.round())
    })
}
