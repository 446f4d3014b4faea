//! The paper's synthetic problem: errors of 5 % in h, l_x, l_y and of 3 µm in every coefficient at the start, 1 µm of noise
//! on every reading, poses within two pitches and ±1.5°.
//!
//! Readings are made in f64 from the plant's side (true pose to outputs, equations 3, 4, 9, 10, 11); the fit is the library's.

use anyhow::{Context, Result};
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSample, JointSolver, Layout, Priors, ReadingNoise, Unknown, Values,
    Weighting, entered,
};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};
use effects::random::{ChaCha8Rng, SeedableRng, normal, sign, uniform};
use hal_sim::trajectory::BEACON_ANGLE_RAD;
use std::f64::consts::TAU;

/// Problems solved, each with its own courier, noise and poses.
pub const PROBLEMS: u64 = 20;
/// Own orders of equation (3).
const ORDERS: [f64; 4] = [1.0, 2.0, 4.0, 6.0];
const NOISE_M: f64 = 1.0e-6;
/// Rms of the true coefficients, metres.
const COEFFICIENT_M: f64 = 5.0e-6;
const INITIAL_SHARE: f64 = 0.05;
const INITIAL_COEFFICIENT_M: f64 = 3.0e-6;
/// Iterations of `output + error(output) = true position`, a contraction by less than a fifth.
const INVERSION: usize = 30;

/// Largest errors over all problems, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Of h.
    pub height_m: f64,
    /// Of l_x and l_y.
    pub lever_m: f64,
    /// Of the error model's coefficients and the parity's offset.
    pub other_m: f64,
    /// Of the beacon's place and the angle's offset: a constant angle is told only by the direction of displacements of a
    /// millimetre, and turns the lever arm.
    pub place_m: f64,
}

/// A courier of the paper's nominal geometry with drawn coefficients.
struct Synthetic {
    /// `[segment][sine, cosine of own orders, then of the lateral order]`, metres.
    k: [[f64; 10]; 4],
    offsets_m: [f64; 4],
    /// Platen sensor's place under the beacon at angle zero, metres.
    place_m: [f64; 2],
    geometry: Geometry,
}

/// Solves `PROBLEMS` problems with these weights; `done` is called after each.
///
/// # Errors
/// A problem that the solver cannot solve.
pub fn worst(seed: u64, poses: u32, weighting: Weighting, mut done: impl FnMut()) -> Result<Worst> {
    let mut worst = Worst::default();
    for problem in 0..PROBLEMS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ (problem << 32) ^ 0x5ca1_ab1e);
        solve(&mut rng, poses, weighting, &mut worst)
            .with_context(|| format!("synthetic problem {problem}"))?;
        done();
    }
    Ok(worst)
}

fn solve(rng: &mut ChaCha8Rng, poses: u32, weighting: Weighting, worst: &mut Worst) -> Result<()> {
    let courier = Synthetic::draw(rng);
    let samples: Vec<JointSample> = (0..poses).map(|_| courier.read(rng)).collect();
    let model = ErrorModel::zero(TermTable::equation_9());
    let layout = Layout::new(&model).context("equation (9) has too many terms")?;
    let noise = ReadingNoise {
        segment_m: NOISE_M as f32,
        displacement_m: NOISE_M as f32,
    };
    let constraints = Constraints {
        geometry: courier.geometry,
        layout,
        noise,
        stated_noise: noise,
        weighting,
    };
    let truth = courier.truth(&constraints.layout, &model);
    let mut values = started(&constraints.layout, &truth, rng);
    let mut solver = Box::new(JointSolver::new());
    solver.set_priors(&constraints, &values, &Priors::default());
    solver
        .fit(
            &constraints,
            &samples.iter().copied(),
            Groups::PAPER,
            &mut values,
        )
        .map_err(|error| anyhow::anyhow!("{error:?}"))?;
    for &index in solver.free() {
        let index = usize::from(index);
        let error_m = f64::from(values[index]) - truth[index];
        let place = match constraints.layout.unknown(index) {
            Unknown::Height => &mut worst.height_m,
            Unknown::Lever(_) => &mut worst.lever_m,
            Unknown::Place(_) | Unknown::AngleOffset => &mut worst.place_m,
            _ => &mut worst.other_m,
        };
        *place = place.max(error_m.abs());
    }
    Ok(())
}

/// Values that the fit starts from.
fn started(layout: &Layout, truth: &[f64], rng: &mut ChaCha8Rng) -> Values {
    let mut values = [0.0; courier_sensor::calibration::joint::JOINT_UNKNOWNS];
    for (index, (value, truth)) in values.iter_mut().zip(truth).enumerate() {
        *value = match layout.unknown(index) {
            Unknown::Coefficient { .. } => truth + INITIAL_COEFFICIENT_M * normal(rng),
            Unknown::Height | Unknown::Lever(_) => truth * (1.0 + INITIAL_SHARE * sign(rng)),
            _ => 0.0,
        } as f32;
    }
    values
}

impl Synthetic {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let mut coefficient = |rms_m: f64| rms_m * normal(rng);
        let k = std::array::from_fn(|_| std::array::from_fn(|_| coefficient(COEFFICIENT_M)));
        // Each pair's mean is gauge: it only moves the beacon's place.
        let [a, b]: [f64; 2] = std::array::from_fn(|_| coefficient(3.0 * COEFFICIENT_M));
        let place_m = std::array::from_fn(|_| uniform(rng, -0.5e-3, 0.5e-3));
        Self {
            k,
            offsets_m: [a, b, -a, -b],
            place_m,
            geometry: Geometry::PAPER,
        }
    }

    /// True values of all unknowns, in the layout's order and gauge.
    fn truth(&self, layout: &Layout, model: &ErrorModel) -> Vec<f64> {
        let o = self.offsets_m;
        let start = entered(layout, model, &self.geometry);
        (0..layout.len())
            .map(|index| match layout.unknown(index) {
                Unknown::Coefficient { segment, .. } => self.k[segment][index % 10],
                Unknown::ParityOffset => o[0] - o[1] - o[2] + o[3],
                Unknown::AngleOffset => o[0] + o[1] - o[2] - o[3],
                Unknown::Place(axis) => self.place_m[axis],
                _ => f64::from(start[index]),
            })
            .collect()
    }

    /// Noisy readings at a drawn pose: the coordination sensor within one pitch of the beacon, turned about it.
    fn read(&self, rng: &mut ChaCha8Rng) -> JointSample {
        let (pitch_m, [lx, ly]) = (
            f64::from(self.geometry.pitch_m),
            self.geometry.lever_m.map(f64::from),
        );
        let theta = uniform(rng, -BEACON_ANGLE_RAD, BEACON_ANGLE_RAD);
        let displaced: [f64; 2] = std::array::from_fn(|_| uniform(rng, -pitch_m, pitch_m));
        let (sine, cosine) = theta.sin_cos();
        // Equation (11) at zero residual, with the beacon over the sensor at `place_m` and angle zero.
        let x_m = self.place_m[0] + displaced[0] + (cosine - 1.0) * lx - sine * ly;
        let y_m = self.place_m[1] + displaced[1] + sine * lx + (cosine - 1.0) * ly;
        let seen = [
            cosine * displaced[0] + sine * displaced[1],
            cosine * displaced[1] - sine * displaced[0],
        ];
        let scale_m = f64::from(self.geometry.height_m) * f64::from(self.geometry.tan_full_scale);
        let mut sample = JointSample::ZERO;
        sample.deflection = seen.map(|c| ((c + NOISE_M * normal(rng)) / scale_m) as f32);
        for (segment, output_m) in self.outputs_m([x_m, y_m, theta]).into_iter().enumerate() {
            let turns = (output_m + NOISE_M * normal(rng)) / pitch_m;
            sample.teeth[segment] = turns.round() as i16;
            sample.fraction_turns[segment] = (turns - turns.round()) as f32;
        }
        sample
    }

    /// Unmodified outputs of a true pose.
    fn outputs_m(&self, [x, y, theta]: [f64; 3]) -> [f64; 4] {
        let arm = 0.5 * f64::from(self.geometry.span_m) * theta;
        let truth = [x + arm, y + arm, x - arm, y - arm];
        let mut outputs = truth;
        for _ in 0..INVERSION {
            let errors = self.errors_m(&outputs);
            outputs = std::array::from_fn(|i| truth[i] - errors[i]);
        }
        outputs
    }

    /// Equations (3) and (9).
    fn errors_m(&self, p: &[f64; 4]) -> [f64; 4] {
        let (px, py) = (0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]));
        let theta = (p[0] - p[2] + p[1] - p[3]) / (2.0 * f64::from(self.geometry.span_m));
        let aside = f64::from(self.geometry.lateral_m) * theta;
        let across = [py - aside, px + aside, py + aside, px - aside];
        let per_m = TAU / f64::from(self.geometry.pitch_m);
        std::array::from_fn(|i| {
            let phases = ORDERS
                .iter()
                .map(|order| order * per_m * p[i])
                .chain([per_m * across[i]]);
            let periodic: f64 = phases
                .zip(self.k[i].chunks_exact(2))
                .map(|(phase, k)| k[0] * phase.sin() + k[1] * phase.cos())
                .sum();
            self.offsets_m[i] + periodic
        })
    }
}
