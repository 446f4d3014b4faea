//! A courier at work anywhere on its platen, at the rate of its rests alone.

use crate::watch::bench::{Calibrated, reading};
use crate::watch::traffic::{Traffic, Work};
use courier_sensor::calibration::rest_watch::{Glance, RestKind, RestWatch};
use courier_sensor::calibration::watch::Reading;
use courier_sensor::geometry::Geometry;
use effects::plant::PlantEffect;
use hal_sim::courier::Courier;

/// Looks of a rest that the watch takes for one, a millisecond each.
const LOOKS: usize = 32;
/// What a rest lasts at least to count, and a step of the clock between rests, seconds.
const REST_S: f64 = 0.04;
const STEP_S: f64 = 0.01;

/// A courier at work.
pub struct AtWork {
    courier: Courier,
    calibrated: Calibrated,
    start_c: f64,
    pub traffic: Traffic,
    pub watch: RestWatch,
    pub time_s: f64,
}

impl AtWork {
    /// At ordinary work, with these changes.
    pub fn new(calibrated: Calibrated, changes: Vec<Box<dyn PlantEffect>>, seed: u64) -> Self {
        let spec = calibrated.spec(changes);
        let mut watch = RestWatch::blank();
        watch.start(RestKind::Parity, Some(stated_m(&calibrated)));
        Self {
            start_c: spec.temperature.start_c,
            courier: Courier::new(spec, seed).expect("a sensor of unique phase"),
            calibrated,
            traffic: Traffic::new(Work::ORDINARY, seed + 1),
            watch,
            time_s: 0.0,
        }
    }

    /// Begins anew for the same calibration, as after a restart.
    pub fn restart(&mut self) {
        let stated_m = stated_m(&self.calibrated);
        self.watch.start(RestKind::Parity, Some(stated_m));
    }

    /// Works until a time; whether `seen` says so after a window, which ends the work.
    pub fn run(&mut self, until_s: f64, mut seen: impl FnMut(&RestWatch) -> bool) -> bool {
        while self.time_s < until_s {
            self.traffic.advance(self.time_s);
            let Some(end_s) = self.traffic.rests_until_s(self.time_s) else {
                self.time_s += STEP_S;
                continue;
            };
            let is_long = end_s - self.time_s >= REST_S;
            if is_long && self.rest() && seen(&self.watch) {
                return true;
            }
            self.time_s = end_s;
        }
        false
    }

    /// One conversion of a rest: its noise is not averaged, which the board does. Whether a window is complete by it.
    fn rest(&mut self) -> bool {
        let time_ms = (1.0e3 * self.time_s) as u64;
        let model = &self.calibrated.model;
        let reading = reading(
            &mut self.courier,
            &self.traffic,
            self.start_c,
            model,
            time_ms,
        );
        let glance = glance(&reading);
        let (now_s, pitch_m) = (self.time_s as u32, Geometry::PAPER.pitch_m);
        let mut is_new = false;
        for _ in 0..LOOKS {
            is_new |= self.watch.take(Some(&glance), now_s, pitch_m);
        }
        self.watch.take(None, now_s, pitch_m);
        is_new
    }
}

/// As the board takes it for what the calibration states.
fn stated_m(calibrated: &Calibrated) -> [f32; 2] {
    [calibrated.quality.residual_after_m, 0.0]
}

/// As the board makes it of a frame: the place by the tooth count.
fn glance(reading: &Reading) -> Glance {
    let [p1, p2, p3, p4] = reading.unmodified;
    let places = [p1.mean(p3), p2.mean(p4)];
    let teeth = places.map(|p| f64::from(p.teeth) + f64::from(p.fraction_turns));
    Glance {
        g_m: [reading.parity_m, 0.0],
        place: teeth.map(|teeth| (0.1 * teeth) as f32),
        temperature_k: reading.temperature_delta_k,
        cell: teeth.map(|teeth| (4.0 * teeth).floor() as i32),
    }
}
