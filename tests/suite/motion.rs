//! The motion port against the simulated controller, byte for byte.

use courier_sensor::drivers::motion::{
    Command, FaultCode, HEARTBEAT_LIMIT_MS, MotionPort, Phase, PortError, Refusal, Reply, Target,
};
use effects::motion::{Motion, Pose};
use hal_sim::wire::clock::Clock;
use hal_sim::wire::motion::{ControllerConfig, Line, Misbehaviour, MotionWire};

const TARGET: Target = Target {
    x_m: 0.010,
    y_m: -0.004,
    theta_rad: 0.005,
};
const GO: Command = Command::GoTo {
    target: TARGET,
    speed_m_per_s: 0.2,
};

fn courier(seed: u64) -> (Clock, MotionWire, MotionPort<Line>) {
    let clock = Clock::new();
    let wire = MotionWire::new(
        clock.clone(),
        ControllerConfig::TYPICAL,
        Pose::default(),
        seed,
    );
    let port = MotionPort::new(wire.line());
    (clock, wire, port)
}

/// Polls every 50 us, at most a tenth of a second.
fn reply(clock: &Clock, port: &mut MotionPort<Line>) -> Option<Reply> {
    (0..2000).find_map(|_| {
        clock.advance_ns(50_000);
        port.poll().unwrap()
    })
}

/// Lets so many milliseconds pass and keeps the motion going.
fn keep_going(clock: &Clock, port: &mut MotionPort<Line>, milliseconds: u32) {
    for _ in 0..milliseconds / 10 {
        port.send(Command::GoOn).unwrap();
        reply(clock, port);
        clock.advance_ns(9_000_000);
    }
}

fn settle(clock: &Clock, port: &mut MotionPort<Line>) -> Option<Target> {
    (0..200).find_map(|_| {
        port.send(Command::GoOn).unwrap();
        match reply(clock, port) {
            Some(Reply::State {
                at,
                phase: Phase::Settled,
            }) => Some(at),
            _ => {
                clock.advance_ns(10_000_000);
                None
            }
        }
    })
}

#[test]
fn goes_settles_and_ends_tens_of_micrometres_off() {
    let mut sum = 0.0;
    for seed in 0..50 {
        let (clock, wire, mut port) = courier(seed);
        port.send(GO).unwrap();
        assert!(matches!(
            reply(&clock, &mut port),
            Some(Reply::State {
                phase: Phase::Moving,
                ..
            })
        ));
        let at = settle(&clock, &mut port).unwrap();
        assert_eq!(at, TARGET, "open loop: it believes what it was told");
        let truth = wire.motion().pose(clock.now_s());
        let speed = wire.motion().velocity(clock.now_s());
        assert!(
            speed.x_m.hypot(speed.y_m) < 40.0e-6,
            "at rest when it says so: {speed:?}"
        );
        sum += (truth.x_m - 0.010).powi(2) + (truth.y_m + 0.004).powi(2);
    }
    // 100 draws of 30 um: the rms has a standard error of 7 %.
    let rms_m = (sum / 100.0f64).sqrt();
    assert!((0.79 * 30.0e-6..1.21 * 30.0e-6).contains(&rms_m), "{rms_m}");
}

#[test]
fn keeps_to_the_speed_limit_and_stops() {
    let (clock, wire, mut port) = courier(1);
    let far = Target { x_m: 0.3, ..TARGET };
    port.send(Command::GoTo {
        target: far,
        speed_m_per_s: 0.2,
    })
    .unwrap();
    reply(&clock, &mut port).unwrap();
    let motion = wire.motion();
    let fastest = (0..200)
        .map(|_| {
            keep_going(&clock, &mut port, 10);
            motion.velocity(clock.now_s()).x_m
        })
        .fold(0.0, f64::max);
    assert!((0.19..0.201).contains(&fastest), "{fastest}");
    let (clock, wire, mut port) = courier(1);
    port.send(Command::GoTo {
        target: far,
        speed_m_per_s: 0.2,
    })
    .unwrap();
    reply(&clock, &mut port).unwrap();
    keep_going(&clock, &mut port, 1000);
    port.send(Command::Stop).unwrap();
    reply(&clock, &mut port).unwrap();
    let at = settle(&clock, &mut port).unwrap();
    let truth = wire.motion().pose(clock.now_s());
    assert!(at.x_m > 0.05 && at.x_m < 0.25 && (truth.x_m - f64::from(at.x_m)).abs() < 2.0e-4);
}

/// The review's fault 11: a board that stops working in mid-motion says nothing, and the courier went on.
#[test]
fn a_motion_without_a_heartbeat_comes_to_rest() {
    let far = Target { x_m: 0.5, ..TARGET };
    let go = Command::GoTo {
        target: far,
        speed_m_per_s: 0.2,
    };
    let (clock, wire, mut port) = courier(1);
    let motion = wire.motion();
    let speed = || motion.velocity(clock.now_s()).x_m;
    let limit_ns = u64::from(HEARTBEAT_LIMIT_MS) * 1_000_000;
    port.send(go).unwrap();
    keep_going(&clock, &mut port, 1000);
    assert!(speed() > 0.05, "it moves");
    // Other questions are no heartbeat.
    port.send(Command::WhereAreYou).unwrap();
    reply(&clock, &mut port).unwrap();
    clock.advance_ns(limit_ns / 2);
    assert!(speed() > 0.05, "half the time is no reason to stop");
    // From 0.2 m/s at 5 m/s^2 in 80 ms.
    clock.advance_ns(limit_ns / 2 + 100_000_000);
    assert!(speed().abs() < 1.0e-3, "{}", speed());
    let at = settle(&clock, &mut port).unwrap();
    assert!((0.02..0.3).contains(&at.x_m), "{at:?}");
    // A heartbeat alone moves nothing; the next command does.
    keep_going(&clock, &mut port, 500);
    assert_eq!(settle(&clock, &mut port), Some(at));
    port.send(go).unwrap();
    keep_going(&clock, &mut port, 4000);
    assert_eq!(settle(&clock, &mut port), Some(far));
}

#[test]
fn refuses_by_name() {
    let (clock, _wire, mut port) = courier(1);
    let outside = Target {
        x_m: 10.0,
        ..TARGET
    };
    for (command, refusal) in [
        (
            Command::GoTo {
                target: outside,
                speed_m_per_s: 0.1,
            },
            Refusal::OutOfReach,
        ),
        (
            Command::GoTo {
                target: TARGET,
                speed_m_per_s: 0.0,
            },
            Refusal::BadSpeed,
        ),
    ] {
        port.send(command).unwrap();
        assert_eq!(reply(&clock, &mut port), Some(Reply::Refused(refusal)));
    }
    let endless = Command::GoTo {
        target: Target {
            x_m: f32::NAN,
            ..TARGET
        },
        speed_m_per_s: 0.1,
    };
    assert_eq!(port.send(endless), Err(PortError::NotFinite));
}

#[test]
fn a_controller_at_fault_is_seen_and_never_waited_for() {
    let (clock, wire, mut port) = courier(1);
    wire.misbehave(Misbehaviour::Silent);
    port.send(GO).unwrap();
    assert_eq!(reply(&clock, &mut port), None);
    assert!(port.is_awaiting());

    wire.misbehave(Misbehaviour::Nonsense);
    for _ in 0..100 {
        port.send(GO).unwrap();
        assert_eq!(reply(&clock, &mut port), None);
    }
    assert!(port.counters().frames.bad() >= 100, "{:?}", port.counters());

    wire.misbehave(Misbehaviour::Faulted(FaultCode::Overload));
    port.send(GO).unwrap();
    assert_eq!(
        reply(&clock, &mut port),
        Some(Reply::Fault(FaultCode::Overload))
    );

    wire.misbehave(Misbehaviour::NeverSettles);
    port.send(GO).unwrap();
    assert!(reply(&clock, &mut port).is_some());
    assert_eq!(settle(&clock, &mut port), None);

    wire.misbehave(Misbehaviour::None);
    assert!(settle(&clock, &mut port).is_some(), "and all is well again");
}

#[test]
fn a_late_reply_counts_as_stale() {
    let (clock, _wire, mut port) = courier(1);
    port.send(Command::WhereAreYou).unwrap();
    clock.advance_ns(5_000_000);
    port.send(Command::Stop).unwrap();
    assert!(reply(&clock, &mut port).is_some());
    assert_eq!(port.counters().stale, 1);
}
