//! Flash: power cuts, torn slots, pages that do not erase.

use crate::rig::{Rig, amount, marked, on_chip};
use courier_sensor::frame::Status;
use courier_sensor::link::message::{Action, InForce, Reply, ResetCause, SlotContent};
use courier_sensor::update::layout::SLOTS_START;
use std::time::Duration;

/// So long the reply to a commit is waited for: an erase and the programming take 30 ms.
const COMMIT: Duration = Duration::from_millis(100);

/// Every fifth step of it, the first and the last; each of them in `cargo xtask emulated`, and at every change on the simulated flash
/// (`tests/suite/slots/power_cuts.rs`).
#[test]
fn a_power_cut_in_a_commit_leaves_the_old_calibration_or_the_new_one() {
    let (mut rig, _) = Rig::stored(4);
    let before = rig.flash.0.borrow().steps();
    assert!(matches!(rig.store(2), Ok(Reply::Place(_))));
    let steps = rig.flash.0.borrow().steps() - before;
    assert!(steps > 200, "{steps}: a record and an erased page");
    let commit = Action::Commit {
        lose_unknown: false,
    };
    let every = amount("COURIER_CUT_EVERY", 5);
    let (mut old, mut seen) = (2, [0_u64; 2]);
    for cut in (0..steps).step_by(every as usize).chain([steps]) {
        assert_eq!(rig.ask(Action::take_over(marked(old + 1))), Reply::Done);
        rig.flash.0.borrow_mut().cut_after(cut);
        let reply = rig.link.ask_patiently(commit.clone(), COMMIT).ok();
        rig.assert_none_missed_but_for_the_cut(cut, &reply);
        let mark = rig.mark().expect("one is in force");
        assert!(
            mark == old || mark == old + 1,
            "cut {cut}: {mark} after {old}"
        );
        seen[usize::from(mark != old)] += 1;
        if mark == old && cut < steps {
            assert!(reply.is_none(), "cut {cut}: told that it was stored");
        }
        // Whatever was left, the next one starts from a known mark.
        if mark == old {
            assert!(
                matches!(rig.store(old + 1), Ok(Reply::Place(_))),
                "cut {cut}"
            );
        }
        old += 1;
    }
    assert!(seen[0] > 100 / every && seen[1] > 0, "{seen:?}");
    println!(
        "power cuts: {} of {} left the old calibration, the others the new one",
        seen[0],
        seen[0] + seen[1]
    );
}

impl Rig {
    /// After a commit with a cut: the board has restarted by itself unless the commit went through before the cut.
    fn assert_none_missed_but_for_the_cut(&mut self, cut: u64, reply: &Option<Reply>) {
        if reply.is_some() {
            self.flash.0.borrow_mut().power_up();
            self.link.restart().expect("the board restarts");
        } else {
            self.link.reconnect().expect("the board is back");
            let status = self.status();
            // The emulated board's RAM outlasts the cut; the chip's does not.
            let wanted = match on_chip() {
                true => ResetCause::PowerOn,
                false => ResetCause::BrownOut,
            };
            assert_eq!(status.reset, wanted, "cut {cut}");
        }
        self.assert_none_missed();
    }
}

#[test]
fn both_slots_torn_is_said_and_the_board_runs() {
    let (mut rig, _) = Rig::stored(6);
    assert!(rig.store(2).is_ok());
    for slot in 0..2 {
        rig.flash
            .0
            .borrow_mut()
            .force(SLOTS_START as usize + slot * 2048 + 40, &[0x5A; 8]);
    }
    rig.link.restart().expect("the board restarts");
    rig.run(10);
    let status = rig.status();
    assert_eq!(status.in_force, InForce::None);
    let bits = Status::from_bits_retain(status.status);
    assert!(bits.contains(Status::UNCALIBRATED), "{bits:?}");
    let Reply::Slots(slots) = rig.ask(Action::Slots) else {
        panic!("wanted both slots")
    };
    for slot in slots {
        assert!(matches!(slot.state, SlotContent::Refused(_)), "{slot:?}");
        assert!(slot.state.to_string().contains("torn"), "{slot:?}");
    }
    assert!(matches!(rig.store(3), Ok(Reply::Place(_))));
    rig.assert_none_missed();
}

#[test]
fn a_flash_that_does_not_erase_is_said_and_what_is_stored_stays() {
    let (mut rig, before) = Rig::stored(5);
    rig.flash.0.borrow_mut().wear_out();
    let refusal = rig.store(2).expect_err("it cannot be stored");
    assert!(refusal.to_string().contains("erase"), "{refusal}");
    let in_force = rig.status().in_force;
    assert_eq!(in_force, InForce::Unsaved, "in force until the restart");
    rig.assert_none_missed();
    rig.link.restart().expect("the board restarts");
    assert_eq!(rig.status().in_force, before);
    assert_eq!(rig.mark(), Some(1));
}
