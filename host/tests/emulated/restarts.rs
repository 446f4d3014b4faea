//! Restarts in the middle of something.

use crate::rig::{Rig, short};
use courier_sensor::calibration::recalibration::{Mode, Order};
use courier_sensor::drivers::motion::Target;
use courier_sensor::emulation::Operation;
use courier_sensor::event_log::entry::{Event, Read, decode};
use courier_sensor::health::{Trouble, troubles};
use courier_sensor::link::message::{Action, InForce, MemoryTest, Refusal, Reply, ResetCause};
use courier_sensor::link::telemetry::Channels;

/// The image's code lies below this address on the emulated machine: its flash has 4 MiB there.
const FLASH_LIMIT: u32 = 4 << 20;

/// Nothing of what was under way is left.
fn assert_afresh(rig: &mut Rig) {
    let refusal = rig.link.ask(Action::Abort).expect_err("nothing to abort");
    assert!(refusal.to_string().contains("nothing"), "{refusal}");
    rig.link.listen(|_| Ok(())).expect("the board is there");
    rig.run(100);
    let mut samples = 0;
    let listened = rig.link.listen(|_| {
        samples += 1;
        Ok(())
    });
    listened.expect("the board is there");
    assert_eq!(samples, 0, "no stream until it is asked for");
    rig.assert_none_missed();
}

#[test]
fn a_watchdog_reset_in_the_middle_of_a_session_is_told_and_loses_nothing() {
    let (mut rig, before) = Rig::stored(15);
    assert_eq!(rig.status().reset, ResetCause::PowerOn);
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
    rig.run(1000);
    // The background waits for ever for a part; the interrupt goes on, and is not enough for the watchdog.
    rig.hang.set(Some(Operation::Temperature));
    rig.run(500);
    rig.hang.set(None);
    rig.run(2500);
    rig.link.reconnect().expect("the board is back");
    let status = rig.status();
    assert_eq!(status.reset, ResetCause::Watchdog);
    assert_eq!(status.in_force, before);
    let Reply::LastFault(Some(fault)) = rig.ask(Action::LastFault) else {
        panic!("wanted what was kept over the reset")
    };
    assert_eq!(fault.cause, ResetCause::Watchdog);
    assert!(fault.message.contains("no progress"), "{fault:?}");
    // Where it hung: both addresses are the image's.
    let in_code = |address: u32| (1..FLASH_LIMIT).contains(&address);
    assert!(in_code(fault.program_counter), "{fault:?}");
    assert!(in_code(fault.link_register), "{fault:?}");
    assert_eq!(status.health.faults_in_a_row, 1);
    assert!(!status.health.safe_mode, "{status:?}");
    assert_eq!(rig.mark(), Some(1));
    assert_afresh(&mut rig);
    // It is kept in flash, beyond the next start, with what was under way.
    rig.run(200);
    let story = story(&mut rig);
    let is_told = |event: &Event| match event {
        Event::Started {
            cause: ResetCause::Watchdog,
            fault: Some(kept),
            in_force,
            ..
        } => kept.program_counter == fault.program_counter && *in_force == before,
        _ => false,
    };
    assert!(
        matches!(&story[..], [_, Event::CalibrationBegun(_), started] if is_told(started)),
        "{story:?}"
    );
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
}

/// What the board has kept of its story.
fn story(rig: &mut Rig) -> Vec<Event> {
    let Reply::KeptLog(page) = rig.ask(Action::KeptLog { skip: 0 }) else {
        panic!("wanted the log")
    };
    let events = page.entries().map(|entry| match decode(entry) {
        Some(Read::Known(_, event)) => event,
        other => panic!("{other:?}"),
    });
    events.collect()
}

#[test]
fn a_stack_that_runs_over_is_told_after_the_restart_and_loses_nothing() {
    // Of the main loop, and of the interrupt on top of it.
    for (seed, operation) in [(19, Operation::Temperature), (20, Operation::Convert)] {
        let (mut rig, before) = Rig::stored(seed);
        rig.stack_spent.set(Some(operation));
        rig.run(2500);
        rig.link.reconnect().expect("the board is back");
        let status = rig.status();
        assert_eq!(status.reset, ResetCause::HardFault);
        assert_eq!(status.in_force, before);
        let Reply::LastFault(Some(fault)) = rig.ask(Action::LastFault) else {
            panic!("wanted what was kept over the reset")
        };
        assert_eq!(fault.cause, ResetCause::HardFault);
        assert!(fault.message.starts_with("stack overflow"), "{fault:?}");
        assert_eq!(rig.mark(), Some(1));
        assert_afresh(&mut rig);
    }
}

#[test]
fn a_restart_under_stream_and_session_starts_from_what_is_stored() {
    let (mut rig, before) = Rig::stored(16);
    rig.link.stream(Channels::POSE, 10).expect("a stream");
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
    rig.run(1000);
    rig.assert_none_missed();
    rig.link.restart().expect("the board restarts");
    let status = rig.status();
    assert_eq!(status.reset, ResetCause::Requested);
    assert_eq!(status.in_force, before);
    assert_eq!(rig.mark(), Some(1));
    assert_afresh(&mut rig);
    // Numbers of samples begin anew, by the courier's clock too.
    rig.assert_every_instant_counted();
}

/// The review's fault 12: a record that the firmware fails on restarted the board for ever.
#[test]
fn three_faults_in_a_row_start_the_board_without_what_is_stored_until_it_is_ordered_to() {
    let (mut rig, before) = Rig::stored(21);
    for faults in 1..=3 {
        rig.stack_spent.set(Some(Operation::Temperature));
        rig.run(400);
        rig.link.reconnect().expect("the board is back");
        let status = rig.status();
        assert_eq!(status.reset, ResetCause::HardFault);
        assert_eq!(status.health.faults_in_a_row, faults);
        assert_eq!(status.health.safe_mode, faults == 3);
        match faults {
            3 => {
                assert_eq!(status.boot, Some(Refusal::SafeMode));
                assert_eq!(status.in_force, InForce::None);
            }
            _ => assert_eq!(status.in_force, before),
        }
    }
    let found = troubles(&rig.status().health);
    assert!(found.contains(&Trouble::SafeMode(3)), "{found:?}");
    rig.run(100);
    rig.assert_none_missed();
    rig.link.restart().expect("the board restarts");
    let status = rig.status();
    assert_eq!(status.in_force, before);
    assert_eq!(status.health.faults_in_a_row, 0);
    assert!(!status.health.safe_mode, "{status:?}");
    assert_eq!(status.health.memory, MemoryTest::Passed);
}

/// The review's fault 11: a board that hangs sends no heartbeat, so that the courier comes to rest long before the watchdog acts.
#[test]
fn the_courier_is_at_rest_before_the_watchdog_restarts_a_board_that_hangs() {
    let mut rig = Rig::start(22);
    let far = Action::GoTo {
        target: Target {
            x_m: 0.5,
            ..Target::default()
        },
        speed_m_per_s: 0.3,
    };
    assert_eq!(rig.ask(far), Reply::Done);
    rig.run(300);
    rig.hang.set(Some(Operation::Temperature));
    // The next temperature is asked for within 100 ms; then 200 ms to the brake, and 60 ms of it.
    rig.run(400);
    let place = rig.world.truth().pose.x_m;
    assert!((0.005..0.3).contains(&place), "{place}");
    rig.run(100);
    let later = rig.world.truth().pose.x_m;
    assert!((later - place).abs() < 1.0e-5, "{place} {later}");
    rig.hang.set(None);
}

#[test]
fn what_becomes_of_candidates_outlives_a_restart() {
    let (mut rig, before) = Rig::stored(39);
    assert_eq!(rig.status().recalibration.mode, Mode::Propose);
    let refusal = rig.link.ask(Action::Recalibrate(Order::Accept));
    let refusal = refusal.expect_err("nothing is proposed");
    assert!(refusal.to_string().contains("candidate"), "{refusal}");
    let set = Action::Recalibrate(Order::Set(Mode::Automatic));
    assert_eq!(rig.ask(set), Reply::Done);
    rig.ask(Action::Restart);
    rig.run(100);
    rig.link.reconnect().expect("the board is back");
    let status = rig.status();
    assert_eq!(status.in_force, before);
    assert_eq!(status.recalibration.mode, Mode::Automatic);
}
