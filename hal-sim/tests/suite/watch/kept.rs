//! What the watch keeps over a restart, and power cuts while it does.

use crate::bench::marked;
use courier_sensor::app::keeper::kept::{add, last};
use courier_sensor::calibration::slots::Slots;
use courier_sensor::calibration::watch::Kept;
use hal_sim::wire::flash::Flash;

fn entry(mark: f32) -> Kept {
    let mut kept = Kept::default();
    kept.reference_m = [mark * 1.0e-7; 32];
    (kept.known, kept.apart) = (u16::MAX, u16::MAX);
    kept.sigma_m = mark * 1.0e-6;
    kept
}

/// Marks of the entries that count: without a map, with one.
fn counting(slots: &mut Slots<Flash>) -> [Option<u32>; 2] {
    let room = slots.room_behind(0).expect("a record is there");
    [false, true].map(|with_map| {
        let kept = last(slots.flash_mut(), &room, |bytes| {
            Kept::from_bytes(bytes, with_map)
        });
        kept.map(|kept| (kept.sigma_m * 1.0e6).round() as u32)
    })
}

fn kept(slots: &mut Slots<Flash>, mark: f32, with_map: bool) -> bool {
    let room = slots.room_behind(0).expect("a record is there");
    add(slots.flash_mut(), &room, &entry(mark).bytes(with_map))
}

fn stored() -> Slots<Flash> {
    let mut slots = Slots::new(Flash::new(4, 1), 0);
    slots.commit(&marked(7), false).expect("stored");
    slots
}

#[test]
fn nine_entries_have_room_and_the_last_of_its_kind_counts() {
    let mut slots = stored();
    assert_eq!(counting(&mut slots), [None, None]);
    let mut taken = 0;
    while kept(&mut slots, (taken + 1) as f32, taken % 2 == 1) {
        taken += 1;
    }
    assert!(taken >= 9, "{taken}");
    let [plain, mapped] = [taken - (taken + 1) % 2, taken - taken % 2];
    assert_eq!(counting(&mut slots), [Some(plain), Some(mapped)]);
    let (_, calibration) = slots.load().expect("the record is untouched");
    assert_eq!(calibration.made.uptime_s, 7);
    // Another calibration takes nothing over, and the one before has what it had.
    slots.commit(&marked(8), false).expect("stored");
    let room = slots.room_behind(1).expect("a record is there");
    assert_eq!(
        last(slots.flash_mut(), &room, |bytes| Kept::from_bytes(
            bytes, false
        )),
        None
    );
    slots.roll_back().expect("the one before is there");
    assert_eq!(counting(&mut slots), [Some(plain), Some(mapped)]);
}

#[test]
fn a_cut_leaves_the_entry_before_or_the_new_one_and_room_for_the_next() {
    let mut slots = stored();
    assert!(kept(&mut slots, 1.0, false));
    let before = slots.flash_mut().steps();
    assert!(kept(&mut slots, 2.0, false));
    let steps = slots.flash_mut().steps() - before;
    assert!(steps >= 12, "twelve double words took {steps} steps");
    for cut in 0..=steps {
        let mut slots = stored();
        assert!(kept(&mut slots, 1.0, false));
        slots.flash_mut().cut_after(cut);
        kept(&mut slots, 2.0, false);
        slots.flash_mut().power_up();
        let now = counting(&mut slots)[0];
        assert!(
            now == Some(2) || (now == Some(1) && cut < steps),
            "{cut}: {now:?}"
        );
        let (_, calibration) = slots.load().expect("the record is untouched");
        assert_eq!(calibration.made.uptime_s, 7, "cut {cut}");
        assert!(kept(&mut slots, 3.0, false), "cut {cut}");
        assert_eq!(counting(&mut slots)[0], Some(3), "cut {cut}");
    }
}
