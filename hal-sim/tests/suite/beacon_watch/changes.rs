//! Changes of the beacon and of the diode, and what the watch says of them.

use super::bench::UnderBeacon;
use crate::watch::bench::Calibrated;
use courier_sensor::calibration::rest_watch::{Goes, RestChange, RestKept, RestKind, RestWatch};
use courier_sensor::calibration::watch::Standing;
use effects::motion::Pose;
use effects::plant::{Instant, PlantEffect};
use hal_sim::ageing::Course;
use hal_sim::presets;
use hal_sim::spec::CourierSpec;

/// By when a change begins: the reference is known then.
const BEGIN_S: f64 = 300.0;
/// Within this a change is to be told, as one of a segment is (issue 39): four windows of rests, one a second.
const WITHIN_S: f64 = 60.0;

/// Share of the rests that are told of which may be from before the change: 15 of the window in which it was, of some 90 in a minute.
const BEFORE: f64 = 15.0 / 90.0;

/// The beacon's mount follows the temperature, metres a kelvin.
struct WarmBeacon {
    m_per_k: [f64; 2],
}

impl PlantEffect for WarmBeacon {
    fn scale(&mut self, factor: f64) {
        self.m_per_k = self.m_per_k.map(|m| m * factor);
    }

    fn beacon_m(&mut self, at: &Instant) -> [f64; 2] {
        self.m_per_k.map(|m| m * at.temperature_delta_k)
    }
}

/// The diode's gain changes: another light, or the beacon was lowered.
struct Gain {
    shares: [f64; 2],
    course: Course,
}

impl PlantEffect for Gain {
    fn scale(&mut self, factor: f64) {
        self.shares = self.shares.map(|share| share * factor);
    }

    fn deflection(&mut self, at: &Instant, normalised: &mut [f64; 2]) {
        for (value, share) in normalised.iter_mut().zip(self.shares) {
            *value *= 1.0 + share * self.course.share(at.time_s);
        }
    }
}

/// At an even temperature.
fn even(mut spec: CourierSpec) -> CourierSpec {
    (spec.temperature.rise_k, spec.temperature.swing_k) = (0.0, 0.0);
    spec
}

fn service(changes: Vec<Box<dyn PlantEffect>>, seed: u64) -> UnderBeacon {
    let calibrated = Calibrated::new(|| even(presets::ideal(7)), 1);
    UnderBeacon::new(calibrated, changes, seed)
}

/// Healthy until the change, then what is told within a minute.
fn told(service: &mut UnderBeacon, change: impl FnOnce(&mut UnderBeacon)) -> RestChange {
    assert!(!service.run(BEGIN_S, RestWatch::has_told));
    assert_eq!(service.watch.verdict().standing, Standing::Healthy);
    change(service);
    assert!(service.run(BEGIN_S + WITHIN_S, RestWatch::has_told));
    // What is told first may still have rests from before the change in it.
    service.run(BEGIN_S + WITHIN_S, |_| false);
    service.watch.verdict().change.expect("told")
}

#[test]
fn a_beacon_that_was_moved_is_told_with_its_channel() {
    // By 20 µm along one axis; and by two thirds of a tooth, which is a third backwards.
    for (by_m, axis, wanted_m) in [
        ([20.0e-6, 0.0], 0, 20.0e-6),
        ([0.0, -20.0e-6], 1, -20.0e-6),
        ([0.0, 677.0e-6], 1, -339.0e-6),
    ] {
        let mut service = service(vec![], 2);
        let [x_m, y_m] = by_m;
        let change = told(&mut service, |service| {
            service.move_beacon(Pose::new(x_m, y_m, 0.0));
        });
        assert_eq!((change.axis, change.goes), (axis, Goes::Alike), "{change}");
        // The beacon's place is taken off: a beacon that moves one way makes g go the other, as the diode then reads.
        let off_m = f64::from(change.size_m) - wanted_m;
        let most_m = BEFORE * wanted_m.abs() + 4.0 * f64::from(change.deviation_m);
        assert!(off_m.abs() < most_m, "{change}");
        assert!(f64::from(change.since_s) <= BEGIN_S + 30.0, "{change}");
    }
}

#[test]
fn a_gain_that_changes_is_told_with_the_place() {
    for (shares, axis, goes) in [
        ([0.01, 0.0], 0, Goes::AlongX),
        ([0.0, -0.01], 1, Goes::AlongY),
    ] {
        let gain = Gain {
            shares,
            course: Course::step(BEGIN_S),
        };
        let mut service = service(vec![Box::new(gain)], 3);
        let change = told(&mut service, |_| {});
        assert_eq!((change.axis, change.goes), (axis, goes), "{change}");
        // One percent of half of 5 mm.
        let off_m = f64::from(change.size_m.abs()) - 25.0e-6;
        let most_m = BEFORE * 25.0e-6 + 4.0 * f64::from(change.deviation_m);
        assert!(off_m.abs() < most_m, "{change}");
    }
}

#[test]
fn a_mount_that_follows_the_temperature_is_told_with_it() {
    let calibrated = Calibrated::new(
        || {
            let mut spec = even(presets::ideal(7));
            // A swing of 5 K either way within an hour: days are accelerated.
            (spec.temperature.swing_k, spec.temperature.swing_period_s) = (5.0, 3600.0);
            spec
        },
        1,
    );
    let mount = WarmBeacon {
        m_per_k: [0.0, 5.0e-6],
    };
    let mut service = UnderBeacon::new(calibrated, vec![Box::new(mount)], 4);
    // Through the warmest, at a quarter of the hour, to the coldest.
    assert!(service.run(2700.0, RestWatch::has_told));
    service.run(2700.0, |_| false);
    let change = service.watch.verdict().change.expect("told");
    assert_eq!(
        (change.axis, change.goes),
        (1, Goes::Temperature),
        "{change}"
    );
}

#[test]
fn what_is_small_is_left_alone_and_what_goes_away_is_taken_back() {
    let mut service = service(vec![], 5);
    assert!(!service.run(BEGIN_S, RestWatch::has_told));
    service.move_beacon(Pose::new(1.0e-6, 0.0, 0.0));
    assert!(!service.run(3600.0, RestWatch::has_told));
    service.move_beacon(Pose::new(30.0e-6, 0.0, 0.0));
    assert!(service.run(3700.0, RestWatch::has_told));
    service.move_beacon(Pose::default());
    assert!(service.run(4500.0, |watch| !watch.has_told()));
    assert_eq!(service.watch.verdict().standing, Standing::Healthy);
}

#[test]
fn reference_and_change_come_back_from_what_is_kept() {
    let mut service = service(vec![], 6);
    let change = told(&mut service, |service| {
        service.move_beacon(Pose::new(20.0e-6, 0.0, 0.0));
    });
    let kept = service.watch.kept().expect("there is a reference");
    let bytes = kept.bytes(RestKind::Beacon, true);
    assert_eq!(RestKept::from_bytes(&bytes, RestKind::Beacon, false), None);
    for i in 0..bytes.len() {
        let mut changed = bytes;
        changed[i] ^= 0x10;
        assert_eq!(
            RestKept::from_bytes(&changed, RestKind::Beacon, true),
            None,
            "byte {i}"
        );
    }
    let back = RestKept::from_bytes(&bytes, RestKind::Beacon, true).expect("as it was");
    service
        .watch
        .start(RestKind::Beacon, Some(service.stated_m));
    service.watch.restore(&back);
    let again = service.watch.verdict().change.expect("told before");
    assert_eq!((again.axis, again.goes), (change.axis, change.goes));
    assert_eq!((again.size_m, again.told_s), (change.size_m, 0));
    // It is still there, and not taken back.
    service.run(service.time_s + 300.0, |_| false);
    let again = service.watch.verdict().change.expect("still there");
    assert_eq!((again.axis, again.goes), (change.axis, change.goes));
}
