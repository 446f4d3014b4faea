//! A courier in f64 for the calibration's tests: from a true pose to a frame, by the plant's side of equations (3) and (4).
#![allow(dead_code)]
pub mod beacon;
pub mod fullest;
use courier_sensor::calibration::{
    Action, Evidence, MotionEvent, Outcome, RelativePose, Session, SessionConfig, Visits,
};
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::{Coordinate, Frame, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::ErrorModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

pub const ORDERS: [f64; 4] = [1.0, 2.0, 4.0, 6.0];

/// Error of equation (3) without the constant.
pub fn error_m(k: &[f64], output_m: f64, pitch_m: f64) -> f64 {
    ORDERS
        .iter()
        .zip(k.chunks(2))
        .map(|(n, k)| {
            let (s, c) = (TAU * n * output_m / pitch_m).sin_cos();
            k[0] * s + k[1] * c
        })
        .sum()
}

pub struct Courier {
    pub geometry: Geometry,
    /// `[segment][sine, cosine of orders 1, 2, 4, 6]`, metres.
    pub k: [[f64; 8]; 4],
    pub offsets_m: [f64; 4],
    pub noise_m: f64,
    pub rng: ChaCha8Rng,
    /// Added to the outputs of a pose by its number: outliers, unmodelled structure.
    pub disturb: fn(&mut ChaCha8Rng, u32) -> [f64; 4],
    /// What the motion controller says to a command, by its number.
    pub reply: fn(u32) -> Option<MotionEvent>,
    /// Motion of the courier while it should stand, by the frame's number.
    pub wobble: fn(u32) -> f64,
    pub start: [f64; 3],
    pub sequence: u32,
    pub status: Status,
}

pub fn quiet(_: &mut ChaCha8Rng, _: u32) -> [f64; 4] {
    [0.0; 4]
}

impl Courier {
    pub fn new(seed: u64, amplitude_m: f64, noise_m: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let k = std::array::from_fn(|_| std::array::from_fn(|_| amplitude_m * normal(&mut rng)));
        let offsets_m = std::array::from_fn(|_| 5.0 * amplitude_m * normal(&mut rng));
        let start = [rng.random_range(0.0..0.1), rng.random_range(0.0..0.1), 0.0];
        Self {
            geometry: Geometry::PAPER,
            k,
            offsets_m,
            noise_m,
            rng,
            disturb: quiet,
            reply: |_| Some(MotionEvent::Settled),
            wobble: |_| 0.0,
            start,
            sequence: 0,
            status: Status::UNCALIBRATED,
        }
    }

    /// Unmodified outputs without noise: solves `output + e(output) = true position`.
    pub fn outputs_m(&self, pose: &RelativePose) -> [f64; 4] {
        let (pitch, span) = (
            f64::from(self.geometry.pitch_m),
            f64::from(self.geometry.span_m),
        );
        let (x, y) = (
            self.start[0] + f64::from(pose.x_m),
            self.start[1] + f64::from(pose.y_m),
        );
        let arm = 0.5 * span * (self.start[2] + f64::from(pose.theta_rad));
        let truth = [x + arm, y + arm, x - arm, y - arm];
        std::array::from_fn(|i| {
            let wanted = truth[i] - self.offsets_m[i];
            let mut p = wanted;
            for _ in 0..60 {
                p = wanted - error_m(&self.k[i], p, pitch);
            }
            p
        })
    }

    pub fn frame(&mut self, outputs_m: &[f64; 4]) -> Frame {
        let pitch = f64::from(self.geometry.pitch_m);
        let mut frame = Frame {
            sequence: self.sequence,
            status: self.status,
            ..Frame::default()
        };
        self.sequence = self.sequence.wrapping_add(1);
        for (segment, p) in frame.segments.iter_mut().zip(outputs_m) {
            let turns = (p + self.noise_m * normal(&mut self.rng)) / pitch;
            let teeth = turns.round();
            segment.unmodified = Coordinate {
                teeth: teeth as i32,
                fraction_turns: (turns - teeth) as f32,
            };
            segment.calibrated = segment.unmodified;
            segment.amplitude_counts = 20_000.0;
        }
        let p = frame.segments.map(|s| s.calibrated);
        frame.parity_m = (p[0].minus_turns(p[2]) - p[1].minus_turns(p[3])) * self.geometry.pitch_m;
        frame
    }

    /// Runs a session to its end; returns the outcome and the number of poses asked for.
    pub fn run(&mut self, session: &mut Session, config: SessionConfig) -> (Outcome, u32) {
        session.start(&config).unwrap();
        let mut outputs = [0.0; 4];
        let mut count = 0;
        while session.is_running() {
            if let Some(Action::Go(pose)) = session.poll() {
                outputs = self.outputs_m(&pose);
                let disturbance = (self.disturb)(&mut self.rng, count);
                outputs
                    .iter_mut()
                    .zip(disturbance)
                    .for_each(|(p, d)| *p += d);
                if let Some(event) = (self.reply)(count) {
                    session.motion(event);
                }
                count += 1;
            }
            let wobble = (self.wobble)(self.sequence);
            let frame = self.frame(&outputs.map(|p| p + wobble));
            session.frame(&frame);
        }
        assert_eq!(session.poll(), Some(Action::Stop));
        (session.outcome().unwrap().clone(), count)
    }

    /// Errors of a session's unknowns, in their order: coefficients, then the offsets' parity sum. The model's e maps
    /// outputs to true positions, so it is the plant's own function.
    pub fn parameter_errors(&self, unknowns: &[f32]) -> Vec<f64> {
        let offset: f64 = self
            .offsets_m
            .iter()
            .zip(PARITY_SIGN)
            .map(|(o, s)| o * f64::from(s))
            .sum();
        let truth = self.k.iter().flatten().copied().chain([offset]);
        truth
            .zip(unknowns)
            .map(|(t, &x)| f64::from(x) - t)
            .collect()
    }
}

/// Equation (3)'s, of each segment.
pub fn coefficients(model: &ErrorModel) -> [[f64; 8]; 4] {
    std::array::from_fn(|segment| {
        let mut out = [0.0; 8];
        model.read_columns(segment, &mut out);
        out.map(f64::from)
    })
}

/// What a session ends with, and the session.
pub fn accepted(
    courier: &mut Courier,
    config: SessionConfig,
) -> (ErrorModel, Evidence, Box<Session>) {
    let mut session = Box::new(Session::idle());
    let (outcome, _) = courier.run(&mut session, config);
    (
        outcome.result.unwrap_or_else(|refusal| panic!("{refusal}")),
        outcome.evidence,
        session,
    )
}

/// A session of so many poses, two frames each.
pub fn short_session(poses: u32) -> SessionConfig {
    let default = SessionConfig::default();
    SessionConfig {
        visits: Visits {
            poses,
            held_out_poses: 50,
            frames_per_pose: 2,
            rest: 0,
            frame_noise_m: 1.0e-6,
            ..default.visits
        },
        ..default
    }
}

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Rms over segments and phases of the difference of two sets of corrections, constants aside.
pub fn position_rms(a: &[[f64; 8]; 4], b: &[[f64; 8]; 4]) -> f64 {
    let squares: f64 = a
        .iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    (squares / 8.0).sqrt()
}
