//! The watch over the beacon on the simulated board: at the full rate, through the firmware's own signal path.

use crate::bench::{Bench, marked};
use courier_sensor::calibration::beacon_watch::{BeaconChange, Goes};
use courier_sensor::calibration::record::{Beacon, Calibration};
use courier_sensor::calibration::watch::Standing;
use courier_sensor::drivers::motion::Target;
use courier_sensor::event_log::entry::Event;
use courier_sensor::frame::Status;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, BoardStatus, Reply};
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// How far the beacon is moved, metres: below half a tooth.
const MOVED_M: f64 = 50.0e-6;
/// Samples of a rest: 60 ms, of which 32 are wanted.
const REST_SAMPLES: u32 = 1200;

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

/// Sends the courier from place to place under the beacon, resting at each, until a time, or until `seen` says so of the status; whether it has.
fn work(
    bench: &mut Bench,
    rng: &mut ChaCha8Rng,
    for_s: u32,
    seen: impl Fn(&BoardStatus) -> bool,
) -> bool {
    let until_s = bench.status().time.uptime_s + for_s;
    loop {
        let status = bench.status();
        if seen(&status) || status.time.uptime_s >= until_s {
            return seen(&status);
        }
        let mut within = |half: f64| uniform(rng, -half, half) as f32;
        let order = Action::GoTo {
            target: Target {
                x_m: within(2.0e-3),
                y_m: within(2.0e-3),
                theta_rad: within(8.727e-3),
            },
            speed_m_per_s: 0.2,
        };
        assert_eq!(bench.ask(order), Reply::Done);
        while bench.status().moving {
            bench.run(200);
        }
        bench.run(REST_SAMPLES);
    }
}

fn told(status: &BoardStatus) -> bool {
    status.beacon_watch.change.is_some()
}

fn drift_is_told(bench: &mut Bench) -> bool {
    bench.run(50);
    let status = bench.board.sample().status;
    status.contains(Status::CALIBRATION_DRIFT)
}

#[test]
fn a_beacon_that_was_moved_is_told_in_the_status_every_frame_and_the_log_over_a_restart_too() {
    let flash = SharedFlash::erased(7);
    let mut bench = calibrated_board(&flash);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bench.run(50);
    assert_eq!(bench.status().beacon_watch.standing, Standing::Learning);
    let healthy = |status: &BoardStatus| status.beacon_watch.standing == Standing::Healthy;
    assert!(work(&mut bench, &mut rng, 120, healthy));
    assert!(!work(&mut bench, &mut rng, 20, told));
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
    assert!(work(&mut bench, &mut rng, 60, told));
    let before = bench.status().beacon_watch.change.expect("told");
    let is_right = |change: &BeaconChange| (change.axis, change.goes) == (0, Goes::Alike);
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
