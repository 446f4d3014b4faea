//! The power may go at any step of writing: what was written before is read, and the next entry is taken.

use super::{append, flash, log, read};
use hal_sim::wire::flash::Flash;

/// Entries that a page holds: the newest so many are never lost, wherever a cut falls. Without check bits, which the part has, a mark that was
/// cut may read as none, and its page goes.
const NEWEST: usize = 84;

/// Flash in which so many entries were written.
fn filled(entries: u32, ecc: bool) -> Flash {
    let mut flash = if ecc {
        flash(5)
    } else {
        flash(6).without_ecc()
    };
    (1..=entries).for_each(|number| append(&mut flash, number).unwrap());
    flash
}

fn steps(flash: &Flash, number: u32) -> u64 {
    let mut flash = flash.clone();
    let before = flash.steps();
    append(&mut flash, number).unwrap();
    flash.steps() - before
}

/// Numbers of entries behind which the next one takes more than its own double words: pages that are marked, closed, erased.
fn turning_points() -> Vec<u32> {
    let mut flash = filled(0, true);
    let mut found = Vec::new();
    for number in 1..=500 {
        if steps(&flash, number) > 24 {
            found.push(number - 1);
        }
        append(&mut flash, number).unwrap();
    }
    found
}

#[test]
fn a_cut_at_any_step_costs_no_entry_that_was_there() {
    let points = turning_points();
    assert!(
        points.len() >= 6,
        "five pages are begun, the last over the first: {points:?}"
    );
    let mut outcomes = [0; 2];
    for entries in points.into_iter().chain([3, 90]) {
        for ecc in [true, false] {
            let whole = filled(entries, ecc);
            let before = read(&mut whole.clone()).0;
            for cut in 0..=steps(&whole, entries + 1) {
                let mut flash = whole.clone();
                flash.cut_after(cut);
                let _ = append(&mut flash, entries + 1);
                flash.power_up();
                let after = read(&mut flash).0;
                let what = format!("cut {cut} after {entries} entries, ecc {ecc}");
                let is_there = after.contains(&(entries + 1));
                outcomes[usize::from(is_there)] += 1;
                if ecc {
                    check(&before, &after, &what);
                }
                // And the next ones are taken, over all pages; numbers go on by what was found.
                let next = log(&mut flash).end().last.number + 1;
                assert_eq!(next, entries + 1 + u32::from(is_there), "{what}");
                append(&mut flash, next).unwrap();
                if ecc {
                    check(&before, &read(&mut flash).0, &what);
                }
                // An erase comes first, in eight steps; of the others every eighth goes once round.
                if cut > 8 && cut % 8 != 3 {
                    continue;
                }
                (next + 1..next + 400).for_each(|number| append(&mut flash, number).unwrap());
                let numbers = read(&mut flash).0;
                let newest: Vec<u32> = (next + 400 - NEWEST as u32..next + 400).collect();
                assert!(
                    newest.iter().all(|number| numbers.contains(number)),
                    "{what}: {numbers:?}"
                );
            }
        }
    }
    assert!(
        outcomes[0] > 0 && outcomes[1] > 0,
        "both outcomes were met: {outcomes:?}"
    );
}

/// The newest entries are still there, in any order.
fn check(before: &[u32], after: &[u32], what: &str) {
    let kept = &before[before.len().saturating_sub(NEWEST)..];
    let lost: Vec<&u32> = kept
        .iter()
        .filter(|number| !after.contains(number))
        .collect();
    assert!(lost.is_empty(), "{what}: lost {lost:?}");
}
