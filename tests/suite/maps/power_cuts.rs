//! The power may go at any step: no map that counts is lost, and none counts by half.

use super::{current, flash, maps, store};
use hal_sim::wire::flash::Flash;

type Counting = Vec<(String, u32)>;

fn counting(maps: &[(&str, u32)]) -> Counting {
    maps.iter()
        .map(|(name, mark)| ((*name).to_owned(), *mark))
        .collect()
}

/// Cuts the power at every step of `operation`, with and without check bits, and tells which of two states came about.
fn cut_everywhere(prepare: &[(&str, u32)], operation: impl Fn(&mut Flash), allowed: [Counting; 2]) {
    let prepared = |ecc: bool, seed| {
        let mut flash = if ecc {
            flash(seed)
        } else {
            flash(seed).without_ecc()
        };
        for (name, mark) in prepare {
            store(&mut flash, name, *mark).unwrap();
        }
        flash
    };
    let mut whole = prepared(true, 1);
    let before = whole.steps();
    operation(&mut whole);
    let steps = whole.steps() - before;
    let mut seen = [0; 2];
    for (ecc, seed) in [(true, 1), (false, 2)] {
        for cut in 0..=steps {
            let mut flash = prepared(ecc, seed);
            flash.cut_after(cut);
            operation(&mut flash);
            flash.power_up();
            let now = current(&mut flash);
            let which = allowed.iter().position(|allowed| *allowed == now);
            let which = which.unwrap_or_else(|| panic!("cut {cut} of {steps}, ecc {ecc}: {now:?}"));
            seen[which] += 1;
            assert!(cut < steps || which == 1, "nothing was cut: {now:?}");
            // And a map can be stored at once.
            let slot = store(&mut flash, "a", 99).unwrap();
            assert_eq!(maps(&mut flash).current(slot).unwrap().info.calibration, 99);
        }
    }
    assert!(
        seen[0] > 0 && seen[1] >= 2,
        "both outcomes were met: {seen:?}"
    );
}

#[test]
fn a_cut_while_a_map_is_stored_leaves_what_was_or_the_new_map() {
    let stored = |name, mark| {
        move |flash: &mut Flash| {
            let _ = store(flash, name, mark);
        }
    };
    let both = [counting(&[]), counting(&[("a", 1)])];
    cut_everywhere(&[], stored("a", 1), both);
    let before = [("a", 1), ("b", 2), ("c", 3)];
    let after = counting(&[("a", 1), ("b", 4), ("c", 3)]);
    cut_everywhere(&before, stored("b", 4), [counting(&before), after]);
}

#[test]
fn a_cut_while_a_map_is_forgotten_leaves_it_or_takes_it() {
    let forget = |flash: &mut Flash| {
        let _ = maps(flash).forget(0);
    };
    let before = [("a", 1), ("b", 2)];
    let both = [counting(&before), counting(&[("b", 2)])];
    cut_everywhere(&before, forget, both);
}
