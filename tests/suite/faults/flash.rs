//! The flash under the calibration slots.

use courier_sensor::calibration::record::{Calibration, RecordError};
use courier_sensor::calibration::slots::{SlotError, SlotState, Slots};
use courier_sensor::geometry::Geometry;
use hal_sim::wire::fault::{FaultyFlash, FlashFault, Switch, When};
use hal_sim::wire::flash::Flash;

fn calibration(uptime_s: u32) -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.made.uptime_s = uptime_s;
    calibration
}

#[test]
fn a_flash_at_fault_leaves_what_was_in_force() {
    let faults = [
        (FlashFault::EraseFails, "erase"),
        (FlashFault::EraseLies, "take data"),
        (FlashFault::WriteFails(0), "take data"),
        (FlashFault::WriteFails(64), "take data"),
    ];
    for (fault, wanted) in faults {
        let switch = Switch::new(1);
        let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
        slots.commit(&calibration(1), false).unwrap();
        slots.commit(&calibration(2), false).unwrap();
        switch.set(fault, When::Always);
        let error = slots.commit(&calibration(3), false).unwrap_err();
        assert!(error.to_string().contains(wanted), "{fault:?}: {error}");
        assert_eq!(slots.load().unwrap().1, calibration(2), "{fault:?}");
        switch.clear();
        assert_eq!(slots.load().unwrap().1, calibration(2), "{fault:?}");
        slots.commit(&calibration(4), false).unwrap();
        assert_eq!(slots.load().unwrap().1, calibration(4), "{fault:?}");
    }
}

#[test]
fn a_flash_that_lies_is_found_out_by_reading_back() {
    let switch = Switch::new(1);
    let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
    slots.commit(&calibration(1), false).unwrap();
    switch.set(FlashFault::WriteLies, When::Always);
    assert_eq!(
        slots.commit(&calibration(2), false),
        Err(SlotError::ReadBack { slot: 1 })
    );
    assert_eq!(slots.load().unwrap().1, calibration(1));
    switch.clear();
    slots.commit(&calibration(2), false).unwrap();
    switch.set(FlashFault::WriteLies, When::Always);
    assert_eq!(slots.roll_back(), Err(SlotError::ReadBack { slot: 1 }));
    assert_eq!(slots.load().unwrap().1, calibration(2));
}

#[test]
fn a_flash_that_does_not_read_is_said_and_never_guessed() {
    let switch = Switch::new(1);
    let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
    slots.commit(&calibration(1), false).unwrap();
    switch.set(FlashFault::ReadFails, When::Always);
    assert_eq!(slots.load(), Err(SlotError::NoneInForce));
    assert_eq!(
        slots.list()[0].state,
        SlotState::Refused(RecordError::Unreadable)
    );
    switch.set(FlashFault::ReadFlips(1.0e-2), When::Always);
    assert_eq!(slots.load(), Err(SlotError::NoneInForce));
    switch.clear();
    assert_eq!(slots.load().unwrap().1, calibration(1));
}
