//! Restarts in the middle of something.

use crate::rig::{Rig, short};
use courier_sensor::emulation::Operation;
use courier_sensor::link::message::{Action, Reply, ResetCause};
use courier_sensor::link::telemetry::Channels;

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
    assert_eq!(rig.mark(), Some(1));
    assert_afresh(&mut rig);
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
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
}
