//! The watch on the simulated board: at the full rate, through the firmware's own signal path.

use super::bench::Calibrated;
use crate::bench::Bench;
use core::f64::consts::SQRT_2;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::calibration::watch::{Standing, Verdict};
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Status;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, BoardStatus, CalibrateOrder, Reply};
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::ageing::{Course, OwnWave};
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// When segment 2's order 2 changes, by how much, metres rms.
pub const CHANGE_S: f64 = 60.0;
const SIZE_M: f64 = 1.0e-6;

/// A board whose courier's calibration is in force.
pub fn calibrated_board() -> (Bench, SharedFlash) {
    let calibrated = Calibrated::new(|| presets::ideal(7), 1);
    let mut spec = presets::ideal(7);
    spec.effects.push(Box::new(OwnWave {
        segment: 1,
        order: 2.0,
        amounts_m: [SQRT_2 * SIZE_M, 0.0],
        course: Course::step(CHANGE_S),
    }));
    let world = World::new(spec, ControllerConfig::TYPICAL, Pose::default(), 7);
    let flash = SharedFlash::erased(7);
    let mut bench = Bench::start(world.expect("monotonic"), flash.clone());
    assert_eq!(
        bench.status().watch,
        Verdict::default(),
        "nothing is in force"
    );
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = calibrated.model.clone();
    calibration.quality = calibrated.quality;
    assert_eq!(bench.ask(Action::take_over(calibration)), Reply::Done);
    bench.run(50);
    (bench, flash)
}

/// Sends the courier from place to place until a time, or until `seen` says so of the status; whether it has.
pub fn work(
    bench: &mut Bench,
    rng: &mut ChaCha8Rng,
    until_s: u32,
    seen: impl Fn(&BoardStatus) -> bool,
) -> bool {
    loop {
        let status = bench.status();
        if seen(&status) || status.time.uptime_s >= until_s {
            return seen(&status);
        }
        if !status.moving {
            let mut within = |half: f64| uniform(rng, -half, half) as f32;
            let target = Target {
                x_m: within(0.02),
                y_m: within(0.02),
                theta_rad: within(8.727e-3),
            };
            let order = Action::GoTo {
                target,
                speed_m_per_s: 0.5,
            };
            assert_eq!(bench.ask(order), Reply::Done);
        }
        bench.run(1000);
    }
}

/// Whether the next frame's status says that the calibration has drifted.
fn drift_is_told(bench: &mut Bench) -> bool {
    let status = bench.board.sample().status;
    status.contains(Status::CALIBRATION_DRIFT)
}

#[test]
fn the_board_tells_of_a_change_in_its_status_and_in_every_frame() {
    let (mut bench, _) = calibrated_board();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    assert_eq!(bench.status().watch.standing, Standing::Learning);
    let healthy = |status: &BoardStatus| status.watch.standing == Standing::Healthy;
    assert!(work(&mut bench, &mut rng, CHANGE_S as u32, healthy));
    assert!(!drift_is_told(&mut bench));
    let told = |status: &BoardStatus| status.watch.change.is_some();
    assert!(work(&mut bench, &mut rng, CHANGE_S as u32 + 60, told));
    let verdict = bench.status().watch;
    let change = verdict.change.expect("told");
    assert_eq!((change.segment, change.order), (1, 2), "{verdict}");
    bench.run(50);
    assert!(drift_is_told(&mut bench));
    // A calibration that is given up leaves what was told; one that comes in force begins anew.
    let order = CalibrateOrder {
        poses: 60,
        held_out_poses: 10,
        ..CalibrateOrder::default()
    };
    assert_eq!(bench.ask(Action::Calibrate(order)), Reply::Done);
    bench.run(2000);
    assert_eq!(bench.ask(Action::Abort), Reply::Done);
    bench.run(2000);
    assert_eq!(bench.status().watch.change, Some(change));
    assert!(drift_is_told(&mut bench));
    let Reply::Calibration(calibration) =
        bench.ask(Action::Read(courier_sensor::link::message::Source::InForce))
    else {
        panic!("wanted the calibration in force")
    };
    assert_eq!(bench.ask(Action::load(calibration)), Reply::Done);
    bench.run(50);
    assert_eq!(bench.status().watch.standing, Standing::Learning);
    assert!(!drift_is_told(&mut bench));
}

#[test]
fn a_restart_forgets_neither_the_reference_nor_a_change() {
    let (mut bench, flash) = calibrated_board();
    let commit = Action::Commit {
        lose_unknown: false,
    };
    assert!(matches!(bench.ask(commit), Reply::Place(_)));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let healthy = |status: &BoardStatus| status.watch.standing == Standing::Healthy;
    assert!(work(&mut bench, &mut rng, CHANGE_S as u32, healthy));
    // The reference is there at once, and what changes after it is told.
    let mut bench = Bench::start(bench.board.stop(), flash.clone());
    bench.run(50);
    assert_eq!(bench.status().watch.standing, Standing::Healthy);
    let told = |status: &BoardStatus| status.watch.change.is_some();
    assert!(work(&mut bench, &mut rng, CHANGE_S as u32 + 60, told));
    let before = bench.status().watch.change.expect("told");
    assert_eq!((before.segment, before.order), (1, 2));
    let mut bench = Bench::start(bench.board.stop(), flash);
    bench.run(50);
    let change = bench.status().watch.change.expect("told before");
    assert_eq!((change.segment, change.order), (1, 2));
    assert_eq!(change.size_m, before.size_m);
    bench.run(50);
    assert!(drift_is_told(&mut bench));
    // It is still there, and not taken back.
    work(&mut bench, &mut rng, 40, |_| false);
    let change = bench.status().watch.change.expect("told");
    assert_eq!((change.segment, change.order), (1, 2));
}
