//! The setting behind the calibration's record, and power cuts while it is changed.

use crate::bench::marked;
use courier_sensor::app::keeper::mode::{CHANGES, add, last};
use courier_sensor::calibration::recalibration::Mode;
use courier_sensor::calibration::slots::Slots;
use hal_sim::wire::flash::Flash;

fn stored() -> Slots<Flash> {
    let mut slots = Slots::new(Flash::new(4, 1), 0);
    slots.commit(&marked(7), false).expect("stored");
    slots
}

fn now(slots: &mut Slots<Flash>) -> Option<Mode> {
    let room = slots.room_behind(0).expect("a record is there");
    last(slots.flash_mut(), &room)
}

fn set(slots: &mut Slots<Flash>, mode: Mode) -> bool {
    let room = slots.room_behind(0).expect("a record is there");
    add(slots.flash_mut(), &room, mode)
}

#[test]
fn the_last_of_sixteen_changes_counts() {
    let mut slots = stored();
    assert_eq!(now(&mut slots), None);
    let modes = [Mode::Off, Mode::Automatic, Mode::Propose];
    for mode in modes.into_iter().cycle().take(CHANGES) {
        assert!(set(&mut slots, mode));
        assert_eq!(now(&mut slots), Some(mode));
    }
    let kept = now(&mut slots);
    assert!(!set(&mut slots, Mode::Automatic), "there is no room");
    assert_eq!(now(&mut slots), kept);
    let (_, calibration) = slots.load().expect("the record is untouched");
    assert_eq!(calibration.made.uptime_s, 7);
}

#[test]
fn a_cut_leaves_the_mode_before_or_the_new_one() {
    let mut slots = stored();
    let before = slots.flash_mut().steps();
    assert!(set(&mut slots, Mode::Off));
    let steps = slots.flash_mut().steps() - before;
    assert!(steps >= 1);
    for cut in 0..=steps {
        let mut slots = stored();
        assert!(set(&mut slots, Mode::Off));
        slots.flash_mut().cut_after(cut);
        set(&mut slots, Mode::Automatic);
        slots.flash_mut().power_up();
        let kept = now(&mut slots);
        assert!(
            kept == Some(Mode::Automatic) || (kept == Some(Mode::Off) && cut < steps),
            "{cut}: {kept:?}"
        );
        assert!(set(&mut slots, Mode::Propose), "cut {cut}");
        assert_eq!(now(&mut slots), Some(Mode::Propose), "cut {cut}");
    }
}
