//! What the calibration session refuses, and what it gets over.
use crate::common::*;
use courier_sensor::calibration::*;
use courier_sensor::drivers::motion::{self, FaultCode};
use courier_sensor::frame::Status;
use courier_sensor::range::OutOfRange;

fn refused(courier: &mut Courier, config: SessionConfig) -> Refusal {
    let mut session = Box::new(Session::idle());
    let refusal = courier
        .run(&mut session, config)
        .0
        .result
        .expect_err("refused");
    println!("{refusal}");
    refusal
}

fn courier() -> Courier {
    Courier::new(21, 5.0e-6, 0.3e-6)
}

/// What comes of a motion controller that answers so to a command, by its number.
fn answered(reply: fn(u32) -> Option<MotionEvent>, config: SessionConfig) -> Refusal {
    let mut courier = Courier { reply, ..courier() };
    refused(&mut courier, config)
}

#[test]
fn motion_refusals() {
    let fault = |count| {
        Some(match count {
            0..5 => MotionEvent::Settled,
            _ => MotionEvent::Fault(FaultCode::Overload),
        })
    };
    let wanted = Refusal::MotionFault {
        fault: FaultCode::Overload,
        pose: 4,
    };
    assert_eq!(answered(fault, short_session(100)), wanted);
    let refusal = motion::Refusal::OutOfReach;
    let wanted = Refusal::MotionRefused { refusal, pose: 0 };
    let out = |_| Some(MotionEvent::Refused(motion::Refusal::OutOfReach));
    assert_eq!(answered(out, short_session(100)), wanted);
}

#[test]
fn a_courier_that_never_settles() {
    let mut config = short_session(100);
    config.visits.settle_limit = 500;
    let not_settled = |pose, nonsense| Refusal::NotSettled {
        pose,
        waited: 501,
        limit: 500,
        answers: 0,
        nonsense,
    };
    let nonsense = |count| {
        Some(match count {
            0..9 => MotionEvent::Settled,
            _ => MotionEvent::Nonsense,
        })
    };
    let refusal = answered(nonsense, config.clone());
    assert_eq!(refusal, not_settled(8, 1));
    assert!(refusal.to_string().contains("501") && refusal.to_string().contains("500"));
    assert_eq!(answered(|_| None, config), not_settled(0, 0));
}

#[test]
fn sensor_refusals() {
    let mut clipped = Courier {
        status: Status::CLIPPED_2,
        ..courier()
    };
    let status = Status::CLIPPED_2;
    assert_eq!(
        refused(&mut clipped, short_session(100)),
        Refusal::BadFrames {
            pose: 0,
            status,
            bad: 3,
            limit: 2
        }
    );
    let mut many = short_session(100);
    many.visits.frames_per_pose = 16;
    let mut drifting = Courier {
        wobble: |frame| 1.0e-6 * f64::from(frame),
        ..courier()
    };
    assert!(matches!(
        refused(&mut drifting, many.clone()),
        Refusal::NotStill { lost: 1, .. }
    ));
    let mut shaking = Courier {
        wobble: |frame| {
            if frame < 5000 {
                0.0
            } else {
                2.0e-5 * f64::from(frame).sin()
            }
        },
        ..courier()
    };
    many.visits.poses = 1000;
    assert!(matches!(
        refused(&mut shaking, many),
        Refusal::NotStill { .. }
    ));
}

#[test]
fn one_wild_frame_among_a_poses_is_left_out() {
    let wild = |frame| if frame % 100 == 50 { 1.0e-3 } else { 0.0 };
    let mut config = short_session(200);
    config.visits.frames_per_pose = 16;
    let (model, evidence, _) = accepted(
        &mut Courier {
            wobble: wild,
            ..courier()
        },
        config.clone(),
    );
    let (plain, ..) = accepted(&mut courier(), config);
    assert_eq!(evidence.lost, 0, "{evidence:?}");
    assert!(position_rms(&coefficients(&model), &coefficients(&plain)) < 0.05e-6);
}

#[test]
fn motion_that_cannot_determine_the_coefficients_is_refused() {
    let turn = |turn_rad| {
        let mut config = short_session(500);
        config.visits.range.turn_rad = turn_rad;
        config
    };
    // Without errors and noise a pair's segments see exactly the same: their sum is undetermined.
    let mut exact = Courier::new(21, 0.0, 0.0);
    let rank = refused(&mut exact, turn(0.0));
    assert_eq!(
        rank,
        Refusal::Rank {
            rank: 17,
            unknowns: 33
        }
    );
    assert!(matches!(
        refused(&mut courier(), turn(0.0)),
        Refusal::Condition { .. }
    ));
    match refused(&mut courier(), turn(2.0e-3)) {
        Refusal::Condition { condition, limit } => assert!(condition > limit && limit == 20.0),
        other => panic!("{other}"),
    }
}

/// Fewer poses than can determine the unknowns are refused before anything moves; those that get lost on the way, afterwards.
#[test]
fn too_few_poses_are_refused() {
    let few = short_session(LEAST_POSES - 1);
    assert_eq!(
        Session::idle().start(&few),
        Err(StartError::Range(OutOfRange {
            name: "poses",
            value: 48.0,
            low: 49.0,
            high: 1.0e6
        }))
    );
    fn one_is_off(_: &mut rand_chacha::ChaCha8Rng, count: u32) -> [f64; 4] {
        [if count == 30 { 0.1e-3 } else { 0.0 }, 0.0, 0.0, 0.0]
    }
    let mut courier = Courier {
        disturb: one_is_off,
        ..courier()
    };
    assert_eq!(
        refused(&mut courier, short_session(LEAST_POSES)),
        Refusal::TooFewPoses {
            poses: 48,
            wanted: 49
        }
    );
}

#[test]
fn data_that_do_not_gain_are_refused() {
    // A sensor without error cannot be improved.
    match refused(&mut Courier::new(3, 0.0, 0.3e-6), short_session(200)) {
        Refusal::HeldOut {
            before_m,
            after_m,
            limit_m,
        } => assert!(after_m >= limit_m && limit_m == before_m),
        other => panic!("{other}"),
    }
    fn one_in_four(rng: &mut rand_chacha::ChaCha8Rng, count: u32) -> [f64; 4] {
        [
            if count > 100 && count % 4 == 0 {
                1.0e-3 * normal(rng)
            } else {
                0.0
            },
            0.0,
            0.0,
            0.0,
        ]
    }
    match refused(
        &mut Courier {
            disturb: one_in_four,
            ..courier()
        },
        short_session(400),
    ) {
        Refusal::Outliers {
            refused,
            poses: 400,
            limit: 41,
        } => assert!(refused > 41),
        other => panic!("{other}"),
    }
}

#[test]
fn what_cannot_be_started_is_named_and_a_running_session_goes_on() {
    let mut session = Box::new(Session::idle());
    let mut bad = short_session(100);
    bad.visits.frame_noise_m = f32::NAN;
    assert!(
        session
            .start(&bad)
            .unwrap_err()
            .to_string()
            .starts_with("frame_noise_m is NaN, wanted")
    );
    assert!(!session.is_running());
    session.start(&short_session(100)).unwrap();
    assert_eq!(session.start(&short_session(100)), Err(StartError::Busy));
    session.abort();
    assert_eq!(session.outcome().unwrap().result, Err(Refusal::Aborted));
    assert_eq!(session.poll(), Some(Action::Stop));
    session.start(&short_session(100)).unwrap();
    assert!(session.outcome().is_none());
}
