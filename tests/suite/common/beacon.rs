//! A courier under a beacon in f64: from a true pose to readings, by the plant's side of equations (3), (4), (9), (10), (11).
use super::{ORDERS, normal};
use courier_sensor::calibration::joint::*;
use courier_sensor::calibration::{Action, MotionEvent, Sample};
use courier_sensor::frame::{Coordinate, Frame, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

pub const PITCH: f64 = 1.016e-3;
pub const SPAN: f64 = 9.7e-3;
pub const LATERAL: f64 = 3.0e-3;

pub struct BeaconCourier {
    /// `[segment][sine, cosine of own orders 1, 2, 4, 6, then of lateral order 1]`, metres.
    pub k: [[f64; 10]; 4],
    pub offsets_m: [f64; 4],
    pub height_m: f64,
    pub lever_m: [f64; 2],
    pub origin_m: [f64; 2],
    pub full_scale: f64,
    /// Gain difference and angle, then seven coefficients an axis.
    pub sensor: [f64; 16],
    pub noise_m: f64,
    /// Added to each output of a pose.
    pub structure: fn(&mut ChaCha8Rng) -> [f64; 4],
    pub rng: ChaCha8Rng,
}

/// Everything that was measured at a pose, and where it was.
pub struct Reading {
    pub sample: JointSample,
    pub pose: [f64; 3],
}

impl BeaconCourier {
    pub fn new(seed: u64, k_m: f64, noise_m: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let g = Geometry::PAPER;
        Self {
            k: std::array::from_fn(|_| std::array::from_fn(|_| k_m * normal(&mut rng))),
            // Pair means are gauge: they only move the origin.
            offsets_m: {
                let [a, b]: [f64; 2] = std::array::from_fn(|_| 3.0 * k_m * normal(&mut rng));
                [a, b, -a, -b]
            },
            height_m: f64::from(g.height_m),
            lever_m: g.lever_m.map(f64::from),
            origin_m: [0.01, -0.02],
            full_scale: f64::from(g.tan_full_scale),
            sensor: [0.0; 16],
            noise_m,
            structure: |_| [0.0; 4],
            rng,
        }
    }

    /// Unmodified outputs of a true pose: solves `output + error(outputs) = true position`.
    pub fn outputs_m(&self, [x, y, theta]: [f64; 3]) -> [f64; 4] {
        let arm = 0.5 * SPAN * theta;
        let truth = [x + arm, y + arm, x - arm, y - arm];
        let mut p = truth;
        for _ in 0..50 {
            let e = self.errors_m(&p);
            p = std::array::from_fn(|i| truth[i] - e[i]);
        }
        p
    }

    /// Equation (9) with constants.
    pub fn errors_m(&self, p: &[f64; 4]) -> [f64; 4] {
        let (px, py) = ((p[0] + p[2]) / 2.0, (p[1] + p[3]) / 2.0);
        let theta = (p[0] - p[2] + p[1] - p[3]) / (2.0 * SPAN);
        let across = [
            py - LATERAL * theta,
            px + LATERAL * theta,
            py + LATERAL * theta,
            px - LATERAL * theta,
        ];
        std::array::from_fn(|i| {
            let own: f64 = ORDERS
                .iter()
                .zip(self.k[i].chunks(2))
                .map(|(n, k)| {
                    let (s, c) = (TAU * n * p[i] / PITCH).sin_cos();
                    k[0] * s + k[1] * c
                })
                .sum();
            let (s, c) = (TAU * across[i] / PITCH).sin_cos();
            self.offsets_m[i] + own + self.k[i][8] * s + self.k[i][9] * c
        })
    }

    /// Measured deflection: inverts the sensor's own errors by iteration.
    fn deflection(&self, [x, y, theta]: [f64; 3]) -> [f64; 2] {
        let (s, c) = theta.sin_cos();
        let (dx, dy) = (x - self.origin_m[0], y - self.origin_m[1]);
        let scale = self.height_m * self.full_scale;
        let truth = [
            (c * dx + s * dy - self.lever_m[0]) / scale,
            (c * dy - s * dx - self.lever_m[1]) / scale,
        ];
        let mut u = truth;
        for _ in 0..50 {
            let bent = self.bent(u);
            u = std::array::from_fn(|i| u[i] + truth[i] - bent[i]);
        }
        u
    }

    fn bent(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [gain, turn] = [self.sensor[0], self.sensor[1]];
        let sum = |k: &[f64], u: f64, v: f64| {
            k[0] * u.powi(3)
                + k[1] * u * u * v
                + k[2] * u * v * v
                + k[3] * u * u
                + k[4] * u * v
                + k[5] * v * v
                + k[6] * v.powi(3)
        };
        [
            u + gain * u - turn * v + sum(&self.sensor[2..9], u, v),
            v - gain * v + turn * u + sum(&self.sensor[9..16], v, u),
        ]
    }

    /// Where teeth are counted from: under the beacon at angle zero.
    fn base_teeth(&self) -> [i32; 2] {
        std::array::from_fn(|i| ((self.origin_m[i] + self.lever_m[i]) / PITCH).round() as i32)
    }

    /// Place of the platen sensor under the beacon at angle zero, from there.
    pub fn place_m(&self) -> [f64; 2] {
        let base = self.base_teeth();
        std::array::from_fn(|i| self.origin_m[i] + self.lever_m[i] - f64::from(base[i]) * PITCH)
    }

    /// Noisy readings at a pose.
    pub fn read(&mut self, pose: [f64; 3]) -> JointSample {
        let structure = (self.structure)(&mut self.rng);
        let outputs = self.outputs_m(pose);
        let scale = self.height_m * self.full_scale;
        let deflection = self
            .deflection(pose)
            .map(|u| (u + self.noise_m * normal(&mut self.rng) / scale) as f32);
        let mut sample = Sample::ZERO;
        for ((output, p), d) in sample.unmodified.iter_mut().zip(outputs).zip(structure) {
            let turns = (p + d + self.noise_m * normal(&mut self.rng)) / PITCH;
            *output = Coordinate {
                teeth: turns.round() as i32,
                fraction_turns: (turns - turns.round()) as f32,
            };
        }
        let base = self.base_teeth();
        JointSample::new(&[base[0], base[1], base[0], base[1]], &sample, deflection).unwrap()
    }

    /// The paper's motion: the sensor within one pitch of the beacon, turning about it.
    pub fn pose(&mut self, half_range_m: f64, turn_rad: f64) -> [f64; 3] {
        let theta: f64 = self.rng.random_range(-turn_rad..=turn_rad);
        let mut d = || self.rng.random_range(-half_range_m..=half_range_m);
        let d = [d(), d()];
        let (s, c) = theta.sin_cos();
        let [lx, ly] = self.lever_m;
        [
            self.origin_m[0] + c * lx - s * ly + d[0],
            self.origin_m[1] + s * lx + c * ly + d[1],
            theta,
        ]
    }

    pub fn readings(&mut self, count: usize, half_range_m: f64, turn_rad: f64) -> Vec<Reading> {
        (0..count)
            .map(|_| {
                let pose = self.pose(half_range_m, turn_rad);
                Reading {
                    sample: self.read(pose),
                    pose,
                }
            })
            .collect()
    }

    pub fn constraints(&self) -> Constraints {
        let noise = ReadingNoise {
            segment_m: self.noise_m as f32,
            displacement_m: self.noise_m as f32,
        };
        let layout = Layout::new(&ErrorModel::zero(TermTable::equation_9())).unwrap();
        Constraints {
            geometry: Geometry::PAPER,
            layout,
            noise,
            stated_noise: noise,
            weighting: Weighting::Covariance,
        }
    }

    /// True values of all unknowns, in the layout's order, in its gauge.
    pub fn truth(&self) -> Vec<f64> {
        let o = self.offsets_m;
        let place = self.place_m();
        let mut truth: Vec<f64> = self.k.iter().flatten().copied().collect();
        truth.extend([
            o[0] - o[1] - o[2] + o[3],
            o[0] + o[1] - o[2] - o[3],
            self.height_m,
            self.lever_m[0],
            self.lever_m[1],
        ]);
        truth.extend(place);
        truth.extend(self.sensor);
        truth
    }
}

/// What goes wrong around a [`BeaconCourier`], by the pose's number.
pub struct Trouble {
    pub status: fn(u32) -> Status,
    pub light: fn(u32) -> i16,
}

impl Default for Trouble {
    fn default() -> Self {
        Self {
            status: |_| Status::empty(),
            light: |_| 8000,
        }
    }
}

impl BeaconCourier {
    fn frame(&mut self, pose: [f64; 3], structure: [f64; 4], sequence: u32) -> Frame {
        let mut frame = Frame {
            sequence,
            ..Frame::default()
        };
        let outputs = self.outputs_m(pose);
        for i in 0..4 {
            let turns = (outputs[i] + structure[i] + self.noise_m * normal(&mut self.rng)) / PITCH;
            let unmodified = Coordinate {
                teeth: turns.round() as i32,
                fraction_turns: (turns - turns.round()) as f32,
            };
            frame.segments[i].unmodified = unmodified;
            frame.segments[i].calibrated = unmodified;
        }
        let scale = self.height_m * self.full_scale;
        frame.tan_psi = self
            .deflection(pose)
            .map(|u| ((u + self.noise_m * normal(&mut self.rng) / scale) * self.full_scale) as f32);
        let p = frame.segments.map(|s| s.calibrated);
        frame.parity_m = ((f64::from(p[0].minus_turns(p[2])) - f64::from(p[1].minus_turns(p[3])))
            * PITCH) as f32;
        frame
    }

    /// Runs a joint session from under the beacon to its end, by an open-loop controller 20 um off.
    pub fn run(
        &mut self,
        session: &mut JointSession,
        mut config: JointConfig,
        trouble: &Trouble,
    ) -> JointOutcome {
        session.start(&mut config).unwrap();
        let start = [
            self.origin_m[0] + self.lever_m[0],
            self.origin_m[1] + self.lever_m[1],
            0.0,
        ];
        let (mut pose, mut structure, mut count, mut sequence) = (start, [0.0; 4], 0, 0);
        while session.is_running() {
            if let Some(Action::Go(to)) = session.poll() {
                let off: [f64; 2] = std::array::from_fn(|_| 20.0e-6 * normal(&mut self.rng));
                pose = [
                    start[0] + f64::from(to.x_m) + off[0],
                    start[1] + f64::from(to.y_m) + off[1],
                    f64::from(to.theta_rad),
                ];
                structure = (self.structure)(&mut self.rng);
                count += 1;
                session.motion(MotionEvent::Settled);
            }
            let mut frame = self.frame(pose, structure, sequence);
            frame.status |= (trouble.status)(count - 1);
            frame.raw.electrode_counts = [(trouble.light)(count - 1); 4];
            sequence += 1;
            session.frame(&frame);
            while session.work() {}
        }
        assert_eq!(session.poll(), Some(Action::Stop));
        session.outcome().unwrap().clone()
    }
}
