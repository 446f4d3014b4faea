//! The power may go at any step: nothing committed is lost.

use super::{calibration, commit, flash, in_force, slots};
use hal_sim::wire::flash::Flash;

/// Cuts the power at every step of `operation`, with and without ECC, and tells what is in force afterwards.
fn cut_everywhere(
    prepare: impl Fn(&mut Flash),
    operation: impl Fn(&mut Flash),
    allowed: [Option<f32>; 2],
) {
    let mut whole = flash(1);
    prepare(&mut whole);
    let before = whole.steps();
    operation(&mut whole);
    let steps = whole.steps() - before;
    let mut seen = [0; 2];
    for (ecc, seed) in [(true, 1), (false, 2), (false, 3)] {
        for cut in 0..=steps {
            let mut flash = if ecc {
                flash(seed)
            } else {
                flash(seed).without_ecc()
            };
            prepare(&mut flash);
            flash.cut_after(cut);
            operation(&mut flash);
            flash.power_up();
            let now = in_force(&mut flash);
            let which = allowed.iter().position(|allowed| *allowed == now);
            seen[which
                .unwrap_or_else(|| panic!("cut {cut} of {steps}, ecc {ecc}: {now:?} in force"))] +=
                1;
            assert!(
                cut < steps || now == allowed[1],
                "nothing was cut, yet {now:?} is in force"
            );
            // And it can be used again at once.
            let place = slots(&mut flash).commit(&calibration(9.0), false).unwrap();
            assert_eq!(
                slots(&mut flash).load(),
                Ok((place, calibration(9.0))),
                "cut {cut}, ecc {ecc}"
            );
        }
    }
    assert!(
        seen[0] > 0 && seen[1] >= 3,
        "both outcomes were met: {seen:?}"
    );
}

fn commit_two(flash: &mut Flash) {
    commit(1.0)(flash);
    commit(2.0)(flash);
}

#[test]
fn a_cut_at_any_step_of_the_first_commit_leaves_none_or_the_new_one() {
    cut_everywhere(|_| (), commit(1.0), [None, Some(1.0)]);
}

#[test]
fn a_cut_at_any_step_of_a_later_commit_leaves_the_old_or_the_new_one() {
    cut_everywhere(commit(1.0), commit(2.0), [Some(1.0), Some(2.0)]);
    cut_everywhere(commit_two, commit(3.0), [Some(2.0), Some(3.0)]);
}

#[test]
fn a_cut_at_any_step_of_a_roll_back_leaves_one_of_both_in_force() {
    cut_everywhere(
        commit_two,
        |flash| {
            let _ = slots(flash).roll_back();
        },
        [Some(2.0), Some(1.0)],
    );
}
