//! The watch over the parity at rests on the simulated board: at the full rate, through the firmware's own signal path.

use crate::bench::{Bench, marked};
use crate::rests::{drift_is_told, work};
use crate::watch::bench::Calibrated;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::calibration::rest_watch::{Goes, RestChange};
use courier_sensor::calibration::watch::Standing;
use courier_sensor::event_log::entry::Event;
use courier_sensor::link::message::{Action, BoardStatus, Reply};
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng};
use hal_sim::ageing::Knock;
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// When segment 1 is knocked, seconds, and by how far, metres.
const KNOCK_S: f64 = 100.0;
const SHIFT_M: f64 = 25.0e-6;
/// How far the courier goes, metres: the reference's rests must lie three teeth apart.
const HALF_M: f64 = 4.0e-3;

#[test]
fn a_segment_that_was_knocked_is_told_in_the_status_every_frame_and_the_log_over_a_restart_too() {
    let flash = SharedFlash::erased(7);
    let mut spec = presets::ideal(7);
    spec.effects.push(Box::new(Knock {
        segment: 0,
        at_s: KNOCK_S,
        shift_m: SHIFT_M,
        waves_m: [[0.0; 2]; 2],
    }));
    let world = World::new(spec, ControllerConfig::TYPICAL, Pose::default(), 7);
    let mut bench = Bench::start(world.expect("monotonic"), flash.clone());
    let calibrated = Calibrated::new(|| presets::ideal(7), 1);
    let calibration = Calibration {
        model: calibrated.model.clone(),
        quality: calibrated.quality,
        ..marked(1)
    };
    assert_eq!(bench.ask(Action::take_over(calibration)), Reply::Done);
    let lose_unknown = false;
    let commit = bench.ask(Action::Commit { lose_unknown });
    assert!(matches!(commit, Reply::Place(_)));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    bench.run(50);
    let status = bench.status();
    assert_eq!(status.parity_watch.standing, Standing::Learning);
    assert_eq!(status.beacon_watch.standing, Standing::Unwatched);
    let healthy = |status: &BoardStatus| status.parity_watch.standing == Standing::Healthy;
    assert!(work(
        &mut bench,
        &mut rng,
        (HALF_M, KNOCK_S as u32),
        healthy
    ));
    assert!(!drift_is_told(&mut bench));

    let told = |status: &BoardStatus| status.parity_watch.change.is_some();
    let until_s = KNOCK_S as u32 + 60;
    let for_s = until_s - bench.status().time.uptime_s;
    assert!(work(&mut bench, &mut rng, (HALF_M, for_s), told));
    // What is told first is of a window in which it was.
    work(&mut bench, &mut rng, (HALF_M, 30), |_| false);
    let before = bench.status().parity_watch.change.expect("told");
    let is_right = |change: &RestChange| (change.axis, change.goes) == (2, Goes::Alike);
    assert!(is_right(&before), "{before}");
    assert!(f64::from(before.told_s) >= KNOCK_S, "{before}");
    assert!(drift_is_told(&mut bench));
    // A start is written after ten seconds, and then what came meanwhile.
    bench.run(300_000);
    let is_it = |event: &Event| matches!(event, Event::ParityWatch { change: Some(change), .. } if is_right(change));
    let story = bench.story();
    assert!(story.iter().any(|(_, event)| is_it(event)), "{story:?}");

    let mut bench = Bench::start(bench.board.stop(), flash);
    let again = bench.status().parity_watch.change.expect("told before");
    let off_m = |change: &RestChange| (f64::from(change.size_m) - SHIFT_M).abs();
    assert!(is_right(&again), "{again}");
    assert!(
        off_m(&before).max(off_m(&again)) < 1.0e-6,
        "{before}, {again}"
    );
    assert!(drift_is_told(&mut bench));
}
