//! Changes of the parity, and what the watch says of them.

use super::bench::AtWork;
use crate::watch::bench::Calibrated;
use crate::watch::traffic::Work;
use courier_sensor::calibration::rest_watch::{Goes, RestChange, RestKept, RestKind, RestWatch};
use courier_sensor::calibration::watch::Standing;
use courier_sensor::equations::PARITY_SIGN;
use effects::motion::Pose;
use effects::plant::{Instant, PlantEffect, SEGMENTS, SegmentPoint};
use effects::thermal_drift::ThermalDrift;
use hal_sim::ageing::{Course, Knock};
use hal_sim::presets;
use hal_sim::spec::CourierSpec;

/// By when a change begins: the reference is known then.
const BEGIN_S: f64 = 300.0;
/// Within this a change is to be told, as one of a segment is (issue 39).
const WITHIN_S: f64 = 60.0;
/// Share of the rests that are told of which may be from before the change: 15 of the window in which it was, of some 90 in a minute.
const BEFORE: f64 = 15.0 / 90.0;

/// A segment that reads ahead the more, the further the courier goes from the middle of its work: as over a platen whose lines do not run straight.
struct Skewed {
    segment: usize,
    /// Metres a metre along x and y.
    slopes: [f64; 2],
    course: Course,
}

impl PlantEffect for Skewed {
    fn scale(&mut self, factor: f64) {
        self.slopes = self.slopes.map(|slope| slope * factor);
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        _points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        let Pose { x_m, y_m, .. } = Work::ORDINARY.middle;
        let by_m = self.slopes[0] * (at.pose.x_m - x_m) + self.slopes[1] * (at.pose.y_m - y_m);
        let mut displacement = [0.0; SEGMENTS];
        displacement[self.segment] = by_m * self.course.share(at.time_s);
        displacement
    }
}

/// At an even temperature.
fn even(mut spec: CourierSpec) -> CourierSpec {
    (spec.temperature.rise_k, spec.temperature.swing_k) = (0.0, 0.0);
    spec
}

fn knocked(segment: usize, shift_m: f64, at_s: f64) -> Box<dyn PlantEffect> {
    Box::new(Knock {
        segment,
        at_s,
        shift_m,
        waves_m: [[0.0; 2]; 2],
    })
}

fn work(changes: Vec<Box<dyn PlantEffect>>, seed: u64) -> AtWork {
    let calibrated = Calibrated::new(|| even(presets::ideal(7)), 1);
    AtWork::new(calibrated, changes, seed)
}

/// Healthy until the change, then what is told within a minute.
fn told(work: &mut AtWork) -> RestChange {
    assert!(!work.run(BEGIN_S, RestWatch::has_told));
    assert_eq!(work.watch.verdict().standing, Standing::Healthy);
    assert!(work.run(BEGIN_S + WITHIN_S, RestWatch::has_told));
    // What is told first may still have rests from before the change in it.
    work.run(BEGIN_S + WITHIN_S, |_| false);
    work.watch.verdict().change.expect("told")
}

fn assert_size(change: &RestChange, wanted_m: f64) {
    let off_m = f64::from(change.size_m) - wanted_m;
    let most_m = BEFORE * wanted_m.abs() + 4.0 * f64::from(change.deviation_m);
    assert!(off_m.abs() < most_m, "{change}");
}

#[test]
fn a_segment_that_is_knocked_is_told_alike_everywhere() {
    for (segment, shift_m) in [(0, 20.0e-6), (1, 20.0e-6), (2, -12.0e-6)] {
        let mut work = work(vec![knocked(segment, shift_m, BEGIN_S)], 2);
        let change = told(&mut work);
        assert_eq!((change.axis, change.goes), (2, Goes::Alike), "{change}");
        assert_size(&change, f64::from(PARITY_SIGN[segment]) * shift_m);
        assert!(f64::from(change.since_s) <= BEGIN_S + 30.0, "{change}");
    }
}

#[test]
fn what_grows_along_the_platen_is_told_with_the_place() {
    // 20 µm over 10 teeth. Places count from where the courier worked when the reference was made.
    let slope = 20.0e-6 / (10.0 * 1.016e-3);
    for (slopes, goes) in [([slope, 0.0], Goes::AlongX), ([0.0, -slope], Goes::AlongY)] {
        let skewed = Skewed {
            segment: 0,
            slopes,
            course: Course::step(BEGIN_S),
        };
        let mut work = work(vec![Box::new(skewed)], 3);
        let change = told(&mut work);
        assert_eq!((change.axis, change.goes), (2, goes), "{change}");
        assert_size(&change, 10.0e-6 * (slopes[0] + slopes[1]).signum());
    }
}

#[test]
fn mounts_that_follow_the_temperature_are_told_with_it() {
    let warm = || {
        let mut spec = even(presets::ideal(7));
        // A swing of 5 K either way within an hour: days are accelerated.
        (spec.temperature.swing_k, spec.temperature.swing_period_s) = (5.0, 3600.0);
        spec
    };
    let mounts = ThermalDrift {
        offset_m_per_k: [2.0e-6, 0.0, 0.0, 1.0e-6],
        curvature_per_k: 0.0,
        growth_per_k: 0.0,
    };
    let mut work = AtWork::new(Calibrated::new(warm, 1), vec![Box::new(mounts)], 4);
    // Through the warmest, at a quarter of the hour, to the coldest.
    assert!(work.run(2700.0, RestWatch::has_told));
    work.run(2700.0, |_| false);
    let change = work.watch.verdict().change.expect("told");
    let (axis, goes) = (change.axis, change.goes);
    assert_eq!((axis, goes), (2, Goes::Temperature), "{change}");
    // 3 µm a kelvin, and what is told is of the same rests.
    let a_kelvin_m = f64::from(change.size_m / change.warmer_k);
    assert!((a_kelvin_m - 3.0e-6).abs() < 0.5e-6, "{change}");
}

#[test]
fn what_is_small_is_left_alone_and_what_goes_away_is_taken_back() {
    let there_and_back = [
        knocked(0, 1.0e-6, BEGIN_S),
        knocked(0, 20.0e-6, 3600.0),
        knocked(0, -20.0e-6, 3700.0),
    ];
    let mut work = work(there_and_back.into(), 5);
    assert!(!work.run(3600.0, RestWatch::has_told));
    assert!(work.run(3700.0, RestWatch::has_told));
    assert!(work.run(4500.0, |watch| !watch.has_told()));
    assert_eq!(work.watch.verdict().standing, Standing::Healthy);
}

#[test]
fn reference_and_change_come_back_from_what_is_kept_and_the_places_begin_anew() {
    let mut work = work(vec![knocked(3, 20.0e-6, BEGIN_S)], 6);
    let change = told(&mut work);
    let kept = work.watch.kept().expect("there is a reference");
    let bytes = kept.bytes(RestKind::Parity, false);
    assert_eq!(RestKept::from_bytes(&bytes, RestKind::Beacon, false), None);
    assert_eq!(RestKept::from_bytes(&bytes, RestKind::Parity, true), None);
    let back = RestKept::from_bytes(&bytes, RestKind::Parity, false).expect("as it was");
    work.restart();
    work.watch.restore(&back);
    let again = work.watch.verdict().change.expect("told before");
    assert_eq!((again.axis, again.goes), (change.axis, change.goes));
    assert_eq!((again.size_m, again.told_s), (change.size_m, 0));
    // It is still there, and not taken back.
    work.run(work.time_s + 300.0, |_| false);
    let again = work.watch.verdict().change.expect("still there");
    assert_eq!((again.axis, again.goes), (change.axis, change.goes));
}
