//! The watch over the beacon on the simulated board: at the full rate, through the firmware's own signal path.

use crate::bench::{Bench, marked};
use crate::rests::{drift_is_told, work};
use courier_sensor::calibration::record::{Beacon, Calibration};
use courier_sensor::calibration::rest_watch::{Goes, RestChange};
use courier_sensor::calibration::watch::Standing;
use courier_sensor::event_log::entry::Event;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, BoardStatus, Reply};
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng};
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// How far the beacon is moved, metres: below half a tooth.
const MOVED_M: f64 = 50.0e-6;
/// How far the courier goes under its beacon, metres: within half of the diode's full scale.
const HALF_M: f64 = 2.0e-3;

/// A board under its beacon, whose calibration is stored.
fn calibrated_board(flash: &SharedFlash) -> Bench {
    let spec = presets::ideal(7);
    let world = World::new(spec, ControllerConfig::TYPICAL, Pose::default(), 7);
    let world = world.expect("monotonic");
    world.with_courier(|courier| courier.set_beacon(Some(Pose::default())));
    let mut bench = Bench::start(world, flash.clone());
    let lever = Geometry::PAPER.lever_m;
    let calibration = Calibration {
        beacon: Some(Beacon {
            origin_m: lever.map(|m| -m),
            segment_sd_m: 1.0e-6,
            displacement_sd_m: 1.0e-6,
            ..Beacon::default()
        }),
        ..marked(1)
    };
    assert_eq!(bench.ask(Action::take_over(calibration)), Reply::Done);
    let lose_unknown = false;
    let commit = bench.ask(Action::Commit { lose_unknown });
    assert!(matches!(commit, Reply::Place(_)));
    bench
}

fn told(status: &BoardStatus) -> bool {
    status.beacon_watch.change.is_some()
}

#[test]
fn a_beacon_that_was_moved_is_told_in_the_status_every_frame_and_the_log_over_a_restart_too() {
    let flash = SharedFlash::erased(7);
    let mut bench = calibrated_board(&flash);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bench.run(50);
    assert_eq!(bench.status().beacon_watch.standing, Standing::Learning);
    let healthy = |status: &BoardStatus| status.beacon_watch.standing == Standing::Healthy;
    assert!(work(&mut bench, &mut rng, (HALF_M, 120), healthy));
    assert!(!work(&mut bench, &mut rng, (HALF_M, 20), told));
    assert!(!drift_is_told(&mut bench));

    // The reference is there again after a restart, at which no whole teeth are known, and the change is told against it.
    let mut bench = Bench::start(bench.board.stop(), flash.clone());
    bench.run(50);
    assert_eq!(bench.status().beacon_watch.standing, Standing::Healthy);
    let moved = Pose::new(MOVED_M, 0.0, 0.0);
    bench
        .board
        .world
        .with_courier(|courier| courier.set_beacon(Some(moved)));
    assert!(work(&mut bench, &mut rng, (HALF_M, 60), told));
    let before = bench.status().beacon_watch.change.expect("told");
    let is_right = |change: &RestChange| (change.axis, change.goes) == (0, Goes::Alike);
    assert!(is_right(&before), "{before}");
    assert!(
        (f64::from(before.size_m) - MOVED_M).abs() < 5.0e-6,
        "{before}"
    );
    assert!(drift_is_told(&mut bench));
    // A start is written after ten seconds, and then what came meanwhile.
    bench.run(300_000);
    let is_it = |event: &Event| matches!(event, Event::BeaconWatch { change: Some(change), .. } if is_right(change));
    let story = bench.story();
    assert!(story.iter().any(|(_, event)| is_it(event)), "{story:?}");

    let mut bench = Bench::start(bench.board.stop(), flash);
    let again = bench.status().beacon_watch.change.expect("told before");
    assert!(is_right(&again) && again.size_m == before.size_m, "{again}");
    assert!(drift_is_told(&mut bench));
}
