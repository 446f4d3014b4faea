//! The usual runs of a recording: a schedule of moves and the times at which it is sampled.

use super::{OpenLoop, Path, Schedule};
use crate::coordination::{origin_under, pose_under};
use crate::spec::Places;
use effects::motion::{Motion, Pose};
use effects::plant::Geometry;
use effects::random::{ChaCha8Rng, SeedableRng, uniform};

/// A named motion and its sampling times.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Label in the recording.
    pub name: String,
    /// Sampling times, seconds, increasing.
    pub times_s: Vec<f64>,
}

/// Moves and runs, built in time order.
#[derive(Clone, Debug)]
pub struct Plan {
    /// True motion.
    pub schedule: Schedule,
    /// What is recorded of it.
    pub runs: Vec<Run>,
    geometry: Geometry,
    rng: ChaCha8Rng,
    now_s: f64,
    settling_s: f64,
}

/// Sampling rate of moving runs, hertz: 50 um between samples at 50 mm/s, 20 samples a pitch.
const MOVING_RATE_HZ: f64 = 1000.0;

/// Speed between still poses, m/s.
const POSITIONING_SPEED_M_S: f64 = 0.05;

/// Pause between runs, seconds: long against ten sample intervals, so each is a stretch of its own.
const PAUSE_S: f64 = 0.5;

/// Largest angle of a still pose without a beacon, radians (0.5 degrees).
pub const SCATTER_ANGLE_RAD: f64 = 0.5 * core::f64::consts::PI / 180.0;

/// Largest angle of a still pose under a beacon, radians (1.5 degrees).
pub const BEACON_ANGLE_RAD: f64 = 1.5 * core::f64::consts::PI / 180.0;

impl Plan {
    /// Starts at `home`. `geometry` is the nominal one: commands know no other.
    #[must_use]
    pub fn new(home: Pose, geometry: Geometry, open_loop: OpenLoop, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let schedule_seed = (uniform(&mut rng, 0.0, 1.0) * 2.0_f64.powi(52)) as u64;
        Self {
            schedule: Schedule::new(home, open_loop, geometry.pitch_m, schedule_seed),
            runs: Vec::new(),
            geometry,
            rng,
            now_s: 1.0,
            settling_s: open_loop.settling_s(),
        }
    }

    /// Time at which the next run may start: the plan's duration so far.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.now_s
    }

    /// Goes to a pose and settles, unrecorded.
    #[must_use]
    pub fn go_to(mut self, target: Pose) -> Self {
        self.position(target);
        self
    }

    fn position(&mut self, target: Pose) {
        self.now_s = self
            .schedule
            .go_to(self.now_s, target, POSITIONING_SPEED_M_S, Path::Straight)
            + self.settling_s;
    }

    /// Still poses, one sample each, once settled.
    #[must_use]
    pub fn stills(mut self, name: &str, poses: &[Pose]) -> Self {
        let mut times_s = Vec::with_capacity(poses.len());
        for &pose in poses {
            self.position(pose);
            times_s.push(self.now_s);
        }
        self.finish(name, times_s)
    }

    /// `scatter`: uniform still poses over `0..range_m` in x and y from `corner` and +-`angle_rad`.
    #[must_use]
    pub fn scatter(mut self, count: usize, corner: Pose, range_m: f64, angle_rad: f64) -> Self {
        let rng = &mut self.rng;
        let mut pose = || {
            let offset = Pose::new(
                uniform(rng, 0.0, range_m),
                uniform(rng, 0.0, range_m),
                uniform(rng, -angle_rad, angle_rad),
            );
            corner.plus(offset, 1.0)
        };
        let poses: Vec<_> = (0..count).map(|_| pose()).collect();
        self.stills("scatter", &poses)
    }

    /// `beacon`: still poses under the beacon, turning about the coordination sensor: it stays within +-one pitch of the
    /// beacon (a range of 2 rho), the angle within +-`angle_rad`.
    #[must_use]
    pub fn beacon(mut self, count: usize, origin_m: [f64; 2], angle_rad: f64) -> Self {
        let (geometry, pitch_m) = (self.geometry, self.geometry.pitch_m);
        let rng = &mut self.rng;
        let mut pose = || {
            let offset = [
                uniform(rng, -pitch_m, pitch_m),
                uniform(rng, -pitch_m, pitch_m),
            ];
            pose_under(
                &geometry,
                origin_m,
                offset,
                uniform(rng, -angle_rad, angle_rad),
            )
        };
        let poses: Vec<_> = (0..count).map(|_| pose()).collect();
        self.stills("beacon", &poses)
    }

    /// A straight sweep from pose to pose at a speed, sampled from start to stop, ramps included.
    #[must_use]
    pub fn sweep(self, name: &str, ends: [Pose; 2], speed_m_s: f64) -> Self {
        self.moving(name, ends, speed_m_s, Path::Straight)
    }

    /// There and back: `name` and `name_back`.
    #[must_use]
    pub fn sweep_both_ways(self, name: &str, [from, to]: [Pose; 2], speed_m_s: f64) -> Self {
        self.sweep(name, [from, to], speed_m_s).sweep(
            &format!("{name}_back"),
            [to, from],
            speed_m_s,
        )
    }

    /// `spin`: a turn about the coordination sensor from -`angle_rad` to +`angle_rad` at 0.2 rad/s or less.
    #[must_use]
    pub fn spin(self, origin_m: [f64; 2], angle_rad: f64) -> Self {
        let body_m = self.geometry.lever_m.map(|l| -l);
        let at = |angle| pose_under(&self.geometry, origin_m, [0.0; 2], angle);
        let ends = [at(-angle_rad), at(angle_rad)];
        self.moving("spin", ends, SPIN_SPEED_M_S, Path::Pivot { body_m })
    }

    /// `still`: one pose for a time.
    #[must_use]
    pub fn still(mut self, pose: Pose, duration_s: f64) -> Self {
        self.position(pose);
        let times_s = sampled(self.now_s, self.now_s + duration_s);
        self.now_s += duration_s;
        self.finish("still", times_s)
    }

    fn moving(mut self, name: &str, [from, to]: [Pose; 2], speed_m_s: f64, path: Path) -> Self {
        self.position(from);
        let start_s = self.now_s;
        let end_s = self.schedule.go_to(start_s, to, speed_m_s, path);
        self.now_s = end_s + self.settling_s;
        self.finish(name, sampled(start_s, end_s))
    }

    fn finish(mut self, name: &str, times_s: Vec<f64>) -> Self {
        self.runs.push(Run {
            name: name.into(),
            times_s,
        });
        self.now_s += PAUSE_S;
        self
    }

    /// Number of samples of all runs.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.runs.iter().map(|run| run.times_s.len()).sum()
    }

    /// True pose at a time.
    #[must_use]
    pub fn pose(&self, time_s: f64) -> Pose {
        self.schedule.pose(time_s)
    }

    /// Everything that a recording usually holds: scatter, fly-bys both ways over 40 mm, a slow one, still poses under the
    /// beacon, 8 mm sweeps there both ways, a spin, a still. Some 6500 samples besides twice `poses`.
    #[must_use]
    pub fn usual(
        poses: usize,
        geometry: Geometry,
        places: &Places,
        open_loop: OpenLoop,
        seed: u64,
    ) -> Self {
        let range_m = 10.0 * geometry.pitch_m;
        let origin_m = origin_under(&geometry, places.beacon);
        let x = |length_m: f64| Pose::new(0.5 * length_m, 0.0, 0.0);
        let y = |length_m: f64| Pose::new(0.0, 0.5 * length_m, 0.0);
        let about = |middle: Pose, half: Pose| [middle.plus(half, -1.0), middle.plus(half, 1.0)];
        let slow = about(places.flyby, y(0.5 * FLYBY_M));
        Self::new(places.flyby, geometry, open_loop, seed)
            .scatter(poses, places.scatter_corner, range_m, SCATTER_ANGLE_RAD)
            .sweep_both_ways("flyby_x", about(places.flyby, x(FLYBY_M)), FLYBY_SPEED_M_S)
            .sweep_both_ways("flyby_y", about(places.flyby, y(FLYBY_M)), FLYBY_SPEED_M_S)
            .sweep("flyby_y_slow", slow, SLOW_SPEED_M_S)
            .beacon(poses, origin_m, BEACON_ANGLE_RAD)
            .sweep_both_ways(
                "beacon_x",
                about(places.beacon_sweep, x(BEACON_SWEEP_M)),
                BEACON_SPEED_M_S,
            )
            .sweep_both_ways(
                "beacon_y",
                about(places.beacon_sweep, y(BEACON_SWEEP_M)),
                BEACON_SPEED_M_S,
            )
            .spin(origin_m, SPIN_ANGLE_RAD)
            .still(places.beacon, 0.5)
    }
}

/// Length of a fly-by, metres (3.1.2).
pub const FLYBY_M: f64 = 40.0e-3;
/// Its speed.
pub const FLYBY_SPEED_M_S: f64 = 50.0e-3;
/// Speed of the slow one.
pub const SLOW_SPEED_M_S: f64 = 10.0e-3;
/// Length of a sweep under the beacon, metres (3.2.1).
pub const BEACON_SWEEP_M: f64 = 8.0e-3;
/// Its speed.
pub const BEACON_SPEED_M_S: f64 = 20.0e-3;
/// Half range of the spin, radians (1.2 degrees).
pub const SPIN_ANGLE_RAD: f64 = 1.2 * core::f64::consts::PI / 180.0;
/// Speed of a spin, at an arm of 0.1 m: 0.05 rad/s.
const SPIN_SPEED_M_S: f64 = 5.0e-3;

fn sampled(start_s: f64, end_s: f64) -> Vec<f64> {
    let count = ((end_s - start_s) * MOVING_RATE_HZ) as usize;
    (0..count)
        .map(|i| start_s + i as f64 / MOVING_RATE_HZ)
        .collect()
}
