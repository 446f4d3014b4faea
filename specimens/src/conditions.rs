//! How a courier is moved and recorded: in the usual way, or in a way that is drawn anew for each courier.
//!
//! The usual way is one layout of many. A drawn one has its own kinds of motion in an order of its own, with other speeds, lengths,
//! places and rests; it may be cut short, lack channels, follow another course of temperature, and state its noise wrong.

use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, index, log_uniform, uniform};
use hal_sim::coordination::{origin_under, pose_under};
use hal_sim::spec::{CourierSpec, Temperature};
use hal_sim::trajectory::{BEACON_ANGLE_RAD, OpenLoop, Plan, SCATTER_ANGLE_RAD, SPIN_ANGLE_RAD};
use recording::{Recording, Samples};
use serde::{Deserialize, Serialize};

/// How a case is moved and recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Conditions {
    /// As `Plan::usual` does.
    #[default]
    Usual,
    /// As [`Layout::draw`] draws.
    Drawn,
}

impl Conditions {
    /// Whether they are the usual ones.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::Usual
    }
}

/// A kind of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Still poses here and there.
    Scatter,
    /// Straight, along x.
    AlongX,
    /// Straight, along y.
    AlongY,
    /// Straight, in any direction.
    Askew,
    /// Still poses under the beacon.
    Beacon,
    /// Straight under the beacon, in any direction.
    BeaconSweep,
    /// A turn under the beacon.
    Spin,
    /// A rest.
    Rest,
}

const MOTIONS: [Motion; 8] = [
    Motion::Scatter,
    Motion::AlongX,
    Motion::AlongY,
    Motion::Askew,
    Motion::Beacon,
    Motion::BeaconSweep,
    Motion::Spin,
    Motion::Rest,
];

// Priors without data beside them: what owners of such sensors do, widely drawn, so that no layout is the usual one.
/// One kind of motion in so many is left out.
const MOTION_OUT: usize = 5;
/// Most repeats of a kind of motion.
const REPEATS: usize = 3;
/// Speeds of sweeps, m/s.
const SPEEDS_M_S: [f64; 2] = [4.0e-3, 150.0e-3];
/// Durations of sweeps, s: at a thousand samples a second.
const SWEEP_S: [f64; 2] = [0.3, 2.0];
/// Lengths of sweeps on the open platen, m.
const LENGTHS_M: [f64; 2] = [2.0e-3, 60.0e-3];
/// Lengths of sweeps under the beacon, m.
const BEACON_LENGTHS_M: [f64; 2] = [1.0e-3, 8.0e-3];
/// How far the middle of a sweep lies from the usual one, m.
const AWAY_M: f64 = 10.0e-3;
/// Numbers of still poses of a run.
const POSES: [f64; 2] = [100.0, 1200.0];
/// Durations of rests, s.
const RESTS_S: [f64; 2] = [0.2, 2.0];
/// One recording in so many is cut short.
const CUT: usize = 4;
/// The share of it that is kept.
const KEPT: [f64; 2] = [0.3, 0.95];
/// One courier in so many has no beacon.
const NO_BEACON: usize = 8;
/// One in so many has a reference in place of a beacon.
const REFERENCE: usize = 8;
/// One in so many has a segment less.
const SEGMENT_OUT: usize = 10;
/// One in so many has no thermometer.
const NO_THERMOMETER: usize = 8;
/// One in so many records no commanded poses.
const NO_COMMANDS: usize = 4;
/// One in so many states its noise wrong.
const NOISE_WRONG: usize = 4;
/// By at most this factor, either way.
const NOISE_FACTOR: f64 = 1.25;

/// What is drawn once for a courier and holds for each of its recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Course of the board's temperature.
    pub temperature: Temperature,
    /// Whether there is a beacon.
    pub beacon: bool,
    /// Whether a reference is recorded; then without a beacon.
    pub reference: bool,
    motions: Vec<Motion>,
    segment_out: Option<usize>,
    thermometer: bool,
    commands: bool,
    noise_factor: f64,
}

fn one_in(rng: &mut ChaCha8Rng, many: usize) -> bool {
    index(rng, many) == 0
}

fn between(rng: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    log_uniform(rng, low, high)
}

/// Courses of temperature: a laboratory's, none, one that falls, one that swings faster than the recording lasts, a long rise.
fn temperature(rng: &mut ChaCha8Rng) -> Temperature {
    let usual = Temperature::LABORATORY;
    match index(rng, 5) {
        0 => usual,
        1 => Temperature {
            rise_k: 0.0,
            swing_k: 0.05,
            ..usual
        },
        2 => Temperature {
            rise_k: -usual.rise_k,
            ..usual
        },
        3 => Temperature {
            rise_k: 0.0,
            swing_k: uniform(rng, 1.0, 4.0),
            swing_period_s: between(rng, [40.0, 200.0]),
            ..usual
        },
        _ => Temperature {
            rise_k: uniform(rng, 8.0, 15.0),
            time_constant_s: between(rng, [300.0, 3000.0]),
            ..usual
        },
    }
}

impl Layout {
    /// Draws one.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rng = &mut rng;
        let reference = one_in(rng, REFERENCE);
        let beacon = !reference && !one_in(rng, NO_BEACON);
        let under_beacon =
            |motion: Motion| matches!(motion, Motion::Beacon | Motion::BeaconSweep | Motion::Spin);
        let mut motions: Vec<Motion> = Vec::new();
        for motion in MOTIONS {
            if (beacon || !under_beacon(motion)) && !one_in(rng, MOTION_OUT) {
                motions.push(motion);
            }
        }
        if motions.is_empty() {
            motions.push(Motion::Askew);
        }
        Self {
            temperature: temperature(rng),
            beacon,
            reference,
            motions,
            segment_out: one_in(rng, SEGMENT_OUT).then(|| index(rng, 4)),
            thermometer: !one_in(rng, NO_THERMOMETER),
            commands: !one_in(rng, NO_COMMANDS),
            noise_factor: if one_in(rng, NOISE_WRONG) {
                log_uniform(rng, 1.0 / NOISE_FACTOR, NOISE_FACTOR)
            } else {
                1.0
            },
        }
    }

    /// Noise over the stated one.
    #[must_use]
    pub fn noise_over_stated(&self) -> f64 {
        1.0 / self.noise_factor
    }

    /// Gives a courier the course of temperature and takes its beacon where there is none.
    pub fn apply(&self, spec: &mut CourierSpec) {
        spec.temperature = self.temperature;
        if !self.beacon {
            spec.beacon_over = None;
        }
    }

    /// The motions of one recording: their order, repeats, speeds, lengths and places are its own.
    #[must_use]
    pub fn plan(&self, spec: &CourierSpec, seed: u64) -> Plan {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut runs: Vec<Motion> = Vec::new();
        for motion in &self.motions {
            for _ in 0..=index(&mut rng, REPEATS) {
                runs.push(*motion);
            }
        }
        for last in (1..runs.len()).rev() {
            let other = index(&mut rng, last + 1);
            runs.swap(last, other);
        }
        let start = Plan::new(spec.places.flyby, spec.nominal, OpenLoop::COURIER, seed);
        let numbered = runs.into_iter().enumerate();
        numbered.fold(start, |plan, (k, motion)| {
            added(plan, motion, k, spec, &mut rng)
        })
    }

    /// What is kept of a recording, and what it states.
    #[must_use]
    pub fn kept(&self, whole: Recording, seed: u64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let length = whole.samples.len();
        let rows = if one_in(&mut rng, CUT) {
            (uniform(&mut rng, KEPT[0], KEPT[1]) * length as f64) as usize
        } else {
            length
        };
        let mut samples = Samples::default();
        for i in 0..rows {
            let mut row = whole.samples.row(i);
            if let Some(segment) = self.segment_out {
                row.quadrature_counts[segment] = None;
                row.teeth[segment] = None;
            }
            row.electrode_counts = row.electrode_counts.filter(|_| self.beacon);
            row.temperature_c = row.temperature_c.filter(|_| self.thermometer);
            row.commanded = row.commanded.map(|value| value.filter(|_| self.commands));
            samples.push(&row);
        }
        let mut meta = whole.meta.clone();
        meta.coordination = meta.coordination.filter(|_| self.beacon);
        let stated = &mut meta.electronics;
        for noise in [
            &mut stated.quadrature_noise_counts,
            &mut stated.psd_noise_counts,
        ] {
            *noise = noise.map(|counts| self.noise_factor * counts);
        }
        Recording {
            meta,
            samples,
            ..whole
        }
    }
}

/// A plan with one more run, whose name ends with its number.
fn added(
    plan: Plan,
    motion: Motion,
    number: usize,
    spec: &CourierSpec,
    rng: &mut ChaCha8Rng,
) -> Plan {
    let origin_m = origin_under(&spec.nominal, spec.places.beacon);
    let count = between(rng, POSES) as usize;
    let rest_s = between(rng, RESTS_S);
    let direction_rad = match motion {
        Motion::AlongX => 0.0,
        Motion::AlongY => 0.5 * core::f64::consts::PI,
        _ => uniform(rng, 0.0, core::f64::consts::TAU),
    };
    match motion {
        Motion::Scatter => {
            let range_m = between(rng, LENGTHS_M);
            let pose = |rng: &mut ChaCha8Rng| {
                Pose::new(
                    uniform(rng, 0.0, range_m),
                    uniform(rng, 0.0, range_m),
                    uniform(rng, -SCATTER_ANGLE_RAD, SCATTER_ANGLE_RAD),
                )
            };
            let poses: Vec<Pose> = (0..count)
                .map(|_| spec.places.scatter_corner.plus(pose(rng), 1.0))
                .collect();
            plan.stills(&format!("scatter_{number}"), &poses)
        }
        Motion::Beacon => {
            let reach_m = spec.nominal.pitch_m;
            let pose = |rng: &mut ChaCha8Rng| {
                let offset_m = [0; 2].map(|_| uniform(rng, -reach_m, reach_m));
                let angle_rad = uniform(rng, -BEACON_ANGLE_RAD, BEACON_ANGLE_RAD);
                pose_under(&spec.nominal, origin_m, offset_m, angle_rad)
            };
            let poses: Vec<Pose> = (0..count).map(|_| pose(rng)).collect();
            plan.stills(&format!("beacon_{number}"), &poses)
        }
        Motion::Spin => plan.spin(origin_m, uniform(rng, 0.2, 1.0) * SPIN_ANGLE_RAD),
        Motion::Rest => plan.still(spec.places.flyby, rest_s),
        Motion::AlongX | Motion::AlongY | Motion::Askew => {
            let away = Pose::new(
                uniform(rng, -AWAY_M, AWAY_M),
                uniform(rng, -AWAY_M, AWAY_M),
                uniform(rng, -SCATTER_ANGLE_RAD, SCATTER_ANGLE_RAD),
            );
            let middle = spec.places.flyby.plus(away, 1.0);
            sweep(
                plan,
                &format!("sweep_{number}"),
                middle,
                direction_rad,
                LENGTHS_M,
                rng,
            )
        }
        Motion::BeaconSweep => sweep(
            plan,
            &format!("beacon_sweep_{number}"),
            spec.places.beacon_sweep,
            direction_rad,
            BEACON_LENGTHS_M,
            rng,
        ),
    }
}

/// A straight sweep about `middle`, one way or both ways, no longer than its duration allows.
fn sweep(
    plan: Plan,
    name: &str,
    middle: Pose,
    direction_rad: f64,
    lengths_m: [f64; 2],
    rng: &mut ChaCha8Rng,
) -> Plan {
    let speed_m_s = between(rng, SPEEDS_M_S);
    let length_m = (speed_m_s * between(rng, SWEEP_S)).clamp(lengths_m[0], lengths_m[1]);
    let half_m = 0.5 * length_m;
    let half = Pose::new(
        half_m * direction_rad.cos(),
        half_m * direction_rad.sin(),
        0.0,
    );
    let ends = [middle.plus(half, -1.0), middle.plus(half, 1.0)];
    if one_in(rng, 3) {
        plan.sweep(name, ends, speed_m_s)
    } else {
        plan.sweep_both_ways(name, ends, speed_m_s)
    }
}
