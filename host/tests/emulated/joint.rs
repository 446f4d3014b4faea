//! The joint calibration under the beacon: the steps' solving shares the processor with everything else.

use crate::rig::{Rig, amount, starter};
use courier::board::{Simulated, Starter, motion, session};
use courier::demo::Preset;
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::calibration::joint::JointConfig;
use courier_sensor::calibration::record::{Calibration, Method};
use courier_sensor::calibration::{Refusal, Stage};
use courier_sensor::drivers::motion::Target;
use courier_sensor::link::message::{Action, CalibrateOrder, InForce, Reply, Source};
use courier_sensor::link::report::{Ending, Progress};
use indicatif::ProgressBar;

/// Name of the image's board in what is printed.
const IMAGE: &str = "image";
/// A reply may be late by a solution for all unknowns; the host gives up after 2 s.
const LATEST_REPLY_NS: u64 = 500_000_000;

fn order(poses: u64, held_out_poses: u16) -> CalibrateOrder {
    let range = JointConfig::default().visits.range;
    CalibrateOrder {
        method: Method::Joint,
        poses: poses as u16,
        held_out_poses,
        travel_m: range.travel_m,
        turn_rad: range.turn_rad,
        ..CalibrateOrder::default()
    }
}

fn in_force(board: &mut Simulated) -> Calibration {
    match board.link.ask(Action::Read(Source::InForce)) {
        Ok(Reply::Calibration(calibration)) => calibration,
        other => panic!("{other:?}"),
    }
}

/// The paper's courier calibrated under its beacon, the result stored; what the board tells after a restart.
fn calibrated(name: &str, board: Starter) -> (Progress, Calibration) {
    let spec = Preset::Paper.courier(1, None, 0.0).expect("a courier");
    let beacon = spec.places.beacon;
    let mut board = Simulated::start(board, spec, 1).expect("the board starts");
    let target = Target {
        x_m: beacon.x_m as f32,
        y_m: beacon.y_m as f32,
        theta_rad: beacon.theta_rad as f32,
    };
    motion::go(&mut board.link, target, SELF_MOTION_M_PER_S).expect("it comes under the beacon");
    // Enough held out that no step's gain is about the least that is accepted: the noise would decide then.
    let order = order(amount("COURIER_EMULATED_POSES", 200), 200);
    let (mut seen, mut asked_ns, mut latest_ns) = (Vec::new(), 0, 0);
    let bar = ProgressBar::hidden();
    let progress = session::run(&mut board, &order, session::LOOK, &bar, |board, now| {
        let now_ns = board.world.clock.now_ns();
        if now.stage == Stage::Solving {
            latest_ns = latest_ns.max(now_ns - asked_ns);
        }
        asked_ns = now_ns;
        if now.stage == Stage::Solving && seen.last() != Some(&now.done) {
            println!(
                "{name}: step {} begins at {:.2} s",
                now.done,
                now_ns as f64 * 1.0e-9
            );
            seen.push(now.done);
        }
        Ok(())
    });
    let progress = progress.expect("it ends");
    let before = in_force(&mut board);
    let status = board.link.status().expect("a status");
    println!(
        "{name}: {} samples, {} missed, {} frames not taken up, longest silence while solving {:.0} ms",
        status.samples,
        status.missed,
        status.dropped_frames,
        latest_ns as f64 * 1.0e-6
    );
    assert_eq!(status.missed, 0);
    assert!(matches!(status.in_force, InForce::Stored(_)), "{status:?}");
    if name == IMAGE {
        assert!(latest_ns < LATEST_REPLY_NS, "{latest_ns}");
        assert_eq!(seen, [0, 1, 2, 3, 4], "each step is seen under way");
    }
    board.link.restart().expect("the board restarts");
    let after = in_force(&mut board);
    assert_eq!(before, after, "what was stored is what was in force");
    assert_eq!(after.method, Method::Joint);
    (progress, after)
}

/// The same courier and poses; noise falls at other places of the motion, as in the other demonstration.
#[test]
fn both_sensors_are_calibrated_as_on_the_simulated_board() {
    let (progress, here) = calibrated("simulated", Starter::default());
    let (other, there) = calibrated(IMAGE, starter());
    let (steps, others) = (progress.steps, other.steps);
    for (a, b) in steps
        .iter()
        .zip(others)
        .map(|(a, b)| (a.expect("made"), b.expect("made")))
    {
        println!("{a:?}\n{b:?}");
        assert_eq!((a.step, a.accepted), (b.step, b.accepted));
        for (a_m, b_m) in a.after.rms_m.into_iter().zip(b.after.rms_m) {
            assert!((b_m / a_m - 1.0).abs() < 0.02, "{a:?}\n{b:?}");
        }
    }
    let lengths = |calibration: &Calibration| {
        let geometry = &calibration.geometry;
        [geometry.height_m, geometry.lever_m[0], geometry.lever_m[1]]
    };
    for (a, b) in lengths(&here).into_iter().zip(lengths(&there)) {
        println!("{a} m simulated, {b} m emulated");
        assert!((b / a - 1.0).abs() < 0.01, "{a} and {b}");
    }
    let (a, b) = (here.beacon.expect("one"), there.beacon.expect("one"));
    println!("{a:?}\n{b:?}");
    assert_eq!(a.origin_teeth, b.origin_teeth);
}

#[test]
fn a_joint_calibration_is_aborted_while_it_solves() {
    let (mut rig, before) = Rig::stored(20);
    assert_eq!(rig.ask(Action::Calibrate(order(60, 16))), Reply::Done);
    loop {
        rig.run(50);
        let now = rig.progress();
        assert!(now.ending.is_none(), "{now:?}");
        if now.stage == Stage::Solving && now.done == 2 {
            break;
        }
    }
    rig.run(10);
    assert_eq!(rig.ask(Action::Abort), Reply::Done);
    let refused = rig.progress().ending;
    assert!(
        matches!(
            refused,
            Some(Ending::Refused {
                refusal: Refusal::Aborted,
                ..
            })
        ),
        "{refused:?}"
    );
    assert_eq!(rig.status().in_force, before);
    assert_eq!(rig.mark(), Some(1));
    rig.assert_none_missed();
    // Another kind of session in the same memory, and this kind once more.
    assert_eq!(rig.ask(Action::Calibrate(crate::rig::short())), Reply::Done);
    rig.run(500);
    assert_eq!(rig.ask(Action::Abort), Reply::Done);
    motion::go(&mut rig.link, Target::default(), SELF_MOTION_M_PER_S)
        .expect("back under the beacon");
    assert_eq!(rig.ask(Action::Calibrate(order(60, 16))), Reply::Done);
    rig.run(500);
    assert_eq!(rig.progress().stage, Stage::Fit);
}
