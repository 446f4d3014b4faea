//! Parts around the processor: converters, their bus, the motion controller.

use crate::rig::{Rig, short};
use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::frame::Status;
use courier_sensor::link::message::{Action, InForce, Reply};
use courier_sensor::update::order::UpdateOrder;
use hal_sim::wire::fault::{InputFault, SpiFault, When};
use hal_sim::wire::motion::Misbehaviour;

/// A session under way.
fn calibrating(seed: u64) -> (Rig, InForce) {
    let (mut rig, before) = Rig::stored(seed);
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
    rig.run(500);
    (rig, before)
}

/// A session ends by the bits of a fault, and afterwards all is as before.
fn ends_by(rig: &mut Rig, wanted: Status, before: InForce) {
    match rig.refusal(10) {
        SessionRefusal::BadFrames { status, .. } => {
            assert!(status.intersects(wanted), "{status:?}, wanted {wanted:?}")
        }
        other => panic!("{other}, wanted {wanted:?}"),
    }
    let status = rig.status();
    let seen = Status::from_bits_retain(status.status | status.status_seen);
    assert!(seen.intersects(wanted), "the reason can be read: {seen:?}");
    assert_eq!(status.in_force, before);
    assert_eq!(rig.mark(), Some(1));
    rig.assert_every_instant_counted();
}

#[test]
fn a_silent_converter_ends_a_session_and_is_set_up_again() {
    let (mut rig, before) = calibrating(11);
    let fault = rig.world.converter.input_fault();
    fault.set(InputFault::Off, When::Always);
    ends_by(&mut rig, Status::CONVERTER_TIMEOUT, before);
    assert!(fault.struck() > 0);
    fault.clear();
    rig.run(200);
    rig.status();
    rig.run(20);
    let seen = Status::from_bits_retain(rig.status().status_seen);
    assert!(!seen.contains(Status::CONVERTER_TIMEOUT), "{seen:?}");
}

#[test]
fn errors_on_the_converters_bus_are_counted_as_such() {
    for chip in 0..2 {
        let (mut rig, before) = calibrating(12);
        rig.bus_faults[chip].set(SpiFault::Flips(0.01), When::Always);
        ends_by(&mut rig, Status::CONVERTER_CRC, before);
        rig.assert_none_missed();
        rig.bus_faults[chip].clear();
        rig.run(200);
        rig.status();
        rig.run(20);
        let seen = Status::from_bits_retain(rig.status().status_seen);
        assert!(!seen.contains(Status::CONVERTER_CRC), "{seen:?}");
    }
}

#[test]
fn a_stuck_channel_ends_a_session_by_its_segments_bit() {
    let stuck = |channel, counts| InputFault::Stuck {
        chip: 0,
        channel,
        counts,
    };
    let cases = [
        (stuck(2, 0), Status::AMPLITUDE_LOW_2 | Status::FROZEN),
        (stuck(7, i16::MAX), Status::CLIPPED_4),
        (InputFault::Frozen, Status::FROZEN),
    ];
    for (fault, wanted) in cases {
        let (mut rig, before) = calibrating(13);
        rig.world.converter.input_fault().set(fault, When::Always);
        ends_by(&mut rig, wanted, before);
        rig.assert_none_missed();
    }
}

#[test]
fn an_absent_motion_controller_is_named() {
    let (mut rig, before) = calibrating(14);
    rig.world.motion.misbehave(Misbehaviour::Silent);
    let refusal = rig.refusal(10);
    assert!(
        matches!(refusal, SessionRefusal::NotSettled { nonsense: 0, .. }),
        "{refusal}"
    );
    assert_eq!(rig.status().in_force, before);
    rig.assert_none_missed();
    // And a session can be ordered again.
    rig.world.motion.misbehave(Misbehaviour::None);
    assert_eq!(rig.ask(Action::Calibrate(short())), Reply::Done);
}

/// The emulated board has one bank of flash and no first stage; on the model of the chip, which has both, this is not run.
#[test]
fn new_firmware_is_refused_in_one_line() {
    let mut rig = Rig::start(11);
    for order in [UpdateOrder::Status, UpdateOrder::Finish] {
        let refused = rig.link.ask(Action::Update(order)).unwrap_err();
        let told = refused.to_string();
        let wanted = "this board takes no firmware over its link: write it with a debug probe";
        assert!(told.ends_with(wanted) && !told.contains('\n'), "{told}");
    }
    rig.assert_undisturbed();
}
