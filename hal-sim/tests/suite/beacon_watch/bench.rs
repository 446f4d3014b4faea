//! A courier at work under its beacon, at the rate of its rests alone.

use crate::watch::bench::Calibrated;
use core::f64::consts::TAU;
use courier_sensor::calibration::rest_watch::{Glance, RestKind, RestWatch};
use courier_sensor::diode;
use courier_sensor::frame::{Coordinate, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{Basis, Observation};
use effects::motion::{Motion, Pose};
use effects::plant::PlantEffect;
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::coordination::{origin_under, pose_under};
use hal_sim::courier::Courier;
use nalgebra::{DMatrix, DVector};

/// A courier that stands.
struct Stands(Pose);

impl Motion for Stands {
    fn pose(&self, _: f64) -> Pose {
        self.0
    }
}

/// Poses of the calibration, as of the paper's.
const CALIBRATION: usize = 1000;
/// Of [`columns`].
const COLUMNS: usize = 4 + diode::AXIS_TERMS;
/// Looks of a rest that the watch takes for one.
const LOOKS: usize = 32;
/// How far a courier goes from under its beacon, metres: within half of the diode's full scale, which is 5 mm.
const FARTHEST_M: f64 = 2.4e-3;
/// As far as the calibration turned it, radians.
const TURN_RAD: f64 = 8.727e-3;

/// Where the courier works under its beacon.
struct Work {
    middle_m: [f64; 2],
    half_m: [f64; 2],
    stops: Vec<Pose>,
    next: usize,
    rest_s: f64,
}

/// A courier at work.
pub struct UnderBeacon {
    courier: Courier,
    calibrated: Calibrated,
    start_c: f64,
    origin_m: [f64; 2],
    /// What a joint calibration takes out of g_x and g_y, metres a column of [`columns`].
    errors_m: [DVector<f64>; 2],
    work: Work,
    rng: ChaCha8Rng,
    pub watch: RestWatch,
    /// What the calibration left of g_x and g_y, metres rms.
    pub stated_m: [f32; 2],
    pub time_s: f64,
}

impl UnderBeacon {
    /// Everywhere under the beacon, with these changes.
    pub fn new(calibrated: Calibrated, changes: Vec<Box<dyn PlantEffect>>, seed: u64) -> Self {
        let spec = calibrated.spec(changes);
        let start_c = spec.temperature.start_c;
        let mut courier = Courier::new(spec, seed).expect("a sensor of unique phase");
        let under = Pose::default();
        courier.set_beacon(Some(under));
        let mut service = Self {
            courier,
            calibrated,
            start_c,
            origin_m: origin_under(&effects::plant::Geometry::PAPER, under),
            errors_m: [0, 1].map(|_| DVector::zeros(COLUMNS)),
            work: Work {
                middle_m: [0.0; 2],
                half_m: [FARTHEST_M; 2],
                stops: vec![],
                next: 0,
                rest_s: 1.0,
            },
            rng: ChaCha8Rng::seed_from_u64(seed),
            watch: RestWatch::blank(),
            stated_m: [0.0; 2],
            time_s: 0.0,
        };
        service.calibrate();
        service
    }

    /// Beacon, lever arm, height and the diode's own errors, by random poses, as a joint calibration finds them.
    fn calibrate(&mut self) {
        let poses = (0..CALIBRATION).map(|_| self.anywhere());
        let poses: Vec<Pose> = poses.collect();
        let seen: Vec<(Glance, f64)> = poses.iter().map(|pose| self.look(*pose)).collect();
        self.errors_m = [0, 1].map(|axis| {
            let row = |i: usize| columns(axis, seen[i].0.place, seen[i].1);
            let design = DMatrix::from_fn(CALIBRATION, COLUMNS, |i, j| row(i)[j]);
            let g_m = DVector::from_fn(CALIBRATION, |i, _| f64::from(seen[i].0.g_m[axis]));
            let svd = design.clone().svd(true, true);
            let errors_m = svd.solve(&g_m, 1.0e-12).expect("both factors");
            let left_m = (g_m - design * &errors_m).norm() / (CALIBRATION as f64).sqrt();
            self.stated_m[axis] = left_m as f32;
            errors_m
        });
        self.watch.start(RestKind::Beacon, Some(self.stated_m));
    }

    /// Moves the beacon, metres.
    pub fn move_beacon(&mut self, by: Pose) {
        self.courier.set_beacon(Some(by));
    }

    /// Other work from now on: a part of what lies under the beacon, with rests of up to 1 to 6 s; every third goes over the same three to
    /// thirty stops again and again.
    pub fn change_work(&mut self) {
        let mut draw = |low: f64, high: f64| uniform(&mut self.rng, low, high);
        let half_m = [draw(0.4e-3, FARTHEST_M), draw(0.4e-3, FARTHEST_M)];
        let middle_m = half_m.map(|half| draw(-1.0, 1.0) * (FARTHEST_M - half));
        let rest_s = draw(1.0, 6.0);
        let repeats = draw(0.0, 3.0) < 1.0;
        let count = if repeats { draw(3.0, 31.0) as usize } else { 0 };
        self.work = Work {
            middle_m,
            half_m,
            stops: vec![],
            next: 0,
            rest_s,
        };
        self.work.stops = (0..count).map(|_| self.anywhere()).collect();
    }

    fn anywhere(&mut self) -> Pose {
        let Work {
            middle_m, half_m, ..
        } = self.work;
        let mut draw = |half: f64| uniform(&mut self.rng, -1.0, 1.0) * half;
        let offset_m = [middle_m[0] + draw(half_m[0]), middle_m[1] + draw(half_m[1])];
        let geometry = effects::plant::Geometry::PAPER;
        pose_under(&geometry, self.origin_m, offset_m, draw(TURN_RAD))
    }

    /// Works until a time; whether `seen` says so after a window, which ends the work.
    pub fn run(&mut self, until_s: f64, mut seen: impl FnMut(&RestWatch) -> bool) -> bool {
        while self.time_s < until_s {
            self.time_s += uniform(&mut self.rng, 0.2, self.work.rest_s);
            let pose = match self.work.stops.get(self.work.next) {
                Some(stop) => *stop,
                None => self.anywhere(),
            };
            self.work.next = (self.work.next + 1) % self.work.stops.len().max(1);
            let glance = self.glance(pose);
            let (now_s, pitch_m) = (self.time_s as u32, Geometry::PAPER.pitch_m);
            let mut is_new = false;
            for _ in 0..LOOKS {
                is_new |= self.watch.take(Some(&glance), now_s, pitch_m);
            }
            self.watch.take(None, now_s, pitch_m);
            if is_new && seen(&self.watch) {
                return true;
            }
        }
        false
    }

    /// What is left of g_x and g_y by the calibration.
    fn glance(&mut self, pose: Pose) -> Glance {
        let (mut glance, theta_rad) = self.look(pose);
        for axis in 0..2 {
            let columns = columns(axis, glance.place, theta_rad);
            let errors = columns.iter().zip(self.errors_m[axis].iter());
            let error_m: f64 = errors.map(|(c, m)| c * m).sum();
            glance.g_m[axis] -= error_m as f32;
        }
        glance
    }

    /// One conversion, as the signal path makes it: its noise is not averaged over the rest, which the board does.
    fn look(&mut self, pose: Pose) -> (Glance, f64) {
        let sample = self.courier.counts_at(&Stands(pose), self.time_s);
        let teeth = self.courier.teeth();
        let geometry = Geometry::PAPER;
        let unmodified: [Coordinate; SEGMENTS] = core::array::from_fn(|s| {
            let [sine, cosine] = sample.quadrature[s].map(f64::from);
            Coordinate {
                teeth: teeth[s],
                fraction_turns: (sine.atan2(cosine) / TAU) as f32,
            }
        });
        let observation = Observation {
            unmodified,
            ..Observation::default()
        };
        let basis = Basis::new(&geometry, &observation);
        let outputs_m: [f64; SEGMENTS] = core::array::from_fn(|s| {
            let error_m = self.calibrated.model.error_m(&basis, s);
            unmodified[s].metres(geometry.pitch_m) + f64::from(error_m)
        });
        let [p1, p2, p3, p4] = outputs_m;
        let span_m = f64::from(geometry.span_m);
        let theta_rad = (p1 - p3 + p2 - p4) / (2.0 * span_m);
        let [xp, xm, yp, ym] = sample.electrodes.map(f64::from);
        let deflection = [(xp - xm) / (xp + xm), (yp - ym) / (yp + ym)];
        let full_m = f64::from(geometry.height_m * geometry.tan_full_scale);
        let (sine, cosine) = theta_rad.sin_cos();
        let a = full_m * deflection[0] + f64::from(geometry.lever_m[0]);
        let b = full_m * deflection[1] + f64::from(geometry.lever_m[1]);
        let sensor_m = [cosine * a - sine * b, sine * a + cosine * b];
        let platen_m = [0.5 * (p1 + p3), 0.5 * (p2 + p4)];
        let quarter_m = 0.25 * f64::from(geometry.pitch_m);
        let glance = Glance {
            g_m: [0, 1].map(|i| (platen_m[i] - self.origin_m[i] - sensor_m[i]) as f32),
            place: deflection.map(|d| d as f32),
            temperature_k: (sample.temperature_c - self.start_c) as f32,
            cell: platen_m.map(|m| (m / quarter_m).floor() as i32),
        };
        (glance, theta_rad)
    }
}

/// One for the beacon's place; the deflections for height, gain and angle; the angle for the lever arm; the diode's own errors.
fn columns(axis: usize, deflection: [f32; 2], theta_rad: f64) -> [f64; COLUMNS] {
    let [u, v] = deflection;
    let (own, other) = if axis == 0 { (u, v) } else { (v, u) };
    let mut columns = [
        1.0,
        f64::from(u),
        f64::from(v),
        theta_rad,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    for (column, value) in columns[4..].iter_mut().zip(diode::functions(own, other)) {
        *column = f64::from(value);
    }
    columns
}
