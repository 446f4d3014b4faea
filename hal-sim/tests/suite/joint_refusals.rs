//! The joint calibration's bad input on the simulated board: each refused by name with both numbers, the calibration in force stays.

use courier_sensor::app::background::{Ended, Errand, SELF_MOTION_M_PER_S};
use courier_sensor::calibration::joint::JointConfig;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::calibration::{Length, Refusal};
use courier_sensor::frame::Status;
use courier_sensor::geometry::Geometry;
use courier_sensor::settings::{ConfigError, Settings};
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::courier::Courier;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// A board of the ideal courier under its beacon, with a calibration in force.
fn board(geometry: Geometry) -> Result<SimBoard, ConfigError> {
    let spec = presets::ideal(1);
    let home = spec.places.beacon;
    let world = World::new(spec, ControllerConfig::TYPICAL, home, 1).unwrap();
    let settings = Settings {
        geometry,
        ..Settings::default()
    };
    let mut board = SimBoard::start(world, SharedFlash::erased(1), settings)?;
    for _ in 0..2000 {
        board.sample();
    }
    let keeper = board.background.keeper_mut().unwrap();
    let own = Calibration {
        device: keeper.device(),
        ..Calibration::identity(geometry)
    };
    keeper.load(&own).unwrap();
    board.sample();
    Ok(board)
}

/// Runs a session, changing the courier at every sample; how it ended. What was in force still is.
fn run(
    board: &mut SimBoard,
    turn_rad: f32,
    mut change: impl FnMut(u32, &mut Courier),
) -> Result<(), Refusal> {
    let before = board.background.keeper().in_force().cloned();
    let mut config = JointConfig::default();
    config.visits.poses = 60;
    config.visits.held_out_poses = 24;
    config.visits.range.turn_rad = turn_rad;
    let errand = Errand {
        speed_m_per_s: SELF_MOTION_M_PER_S,
        commit: false,
    };
    board
        .background
        .calibrate_joint(&mut config, errand)
        .unwrap();
    for sample in 0..2_000_000 {
        board.world.with_courier(|courier| change(sample, courier));
        board.sample();
        if let Some(Ended { result, .. }) = board.background.ended() {
            let result = result.map(|_| ());
            if result.is_err() {
                assert_eq!(board.background.keeper().in_force(), before.as_ref());
            }
            return result;
        }
    }
    panic!("the session has not ended");
}

const TURN_RAD: f32 = 26.0e-3;

fn refused(geometry: Geometry, turn_rad: f32, change: impl FnMut(u32, &mut Courier)) -> Refusal {
    let refusal = run(&mut board(geometry).unwrap(), turn_rad, change).expect_err("refused");
    println!("{refusal}");
    refusal
}

#[test]
fn nothing_wrong_is_accepted() {
    run(&mut board(Geometry::PAPER).unwrap(), TURN_RAD, |_, _| ()).unwrap();
}

#[test]
fn beacon_that_comes_and_goes() {
    let over = presets::ideal(1).places.beacon;
    let blink = |sample: u32, courier: &mut Courier| {
        let lit = sample / 20_000 % 2 == 0;
        courier.set_beacon(lit.then_some(over));
    };
    let refusal = refused(Geometry::PAPER, TURN_RAD, blink);
    assert!(
        matches!(refusal, Refusal::BadFrames { status, .. } if status.contains(Status::BEACON_MISSING)),
        "{refusal}"
    );
}

#[test]
fn recording_without_rotation() {
    let refusal = refused(Geometry::PAPER, 0.0, |_, _| ());
    assert!(
        matches!(refusal, Refusal::NoRotation { turn_rad, wanted_rad } if turn_rad < wanted_rad),
        "{refusal}"
    );
}

#[test]
fn lever_arm_with_the_wrong_sign_and_in_millimetres() {
    let [lx, ly] = Geometry::PAPER.lever_m;
    let wrong_sign = Geometry {
        lever_m: [-lx, ly],
        ..Geometry::PAPER
    };
    match refused(wrong_sign, TURN_RAD, |_, _| ()) {
        Refusal::Geometry {
            name: Length::LeverX,
            entered_m,
            found_m,
            ..
        } => assert!(entered_m < 0.0 && found_m > 0.0),
        other => panic!("{other}"),
    }
    let millimetres = Geometry {
        lever_m: [90.0, ly],
        ..Geometry::PAPER
    };
    let error = board(millimetres).err().expect("refused");
    assert_eq!(error.to_string(), "lever_m is 90, wanted -10 to 10");
}
