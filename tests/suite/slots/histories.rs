//! Random commits, roll backs and power cuts one after the other.

use super::{calibration, flash, in_force, slots};
use courier_sensor::calibration::slots::SlotState;
use hal_sim::wire::flash::Flash;

/// Random commits, roll backs and power cuts against a model: what may be in force is known after each.
#[test]
fn random_histories_agree_with_a_model() {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    let (mut cuts, mut rolled) = (0, 0);
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut flash = flash(seed);
        // In force, and what a roll back would bring: known for certain or not there.
        let (mut now, mut older): (Option<f32>, Option<f32>) = (None, None);
        for number in 1..=40 {
            let cut = (rng.next_u32() % 3 == 0).then(|| u64::from(rng.next_u32() % 900));
            if let Some(steps) = cut {
                flash.cut_after(steps);
            }
            let commit = rng.next_u32() % 3 != 0;
            let mark = number as f32;
            let (after, done) = if commit {
                let done = slots(&mut flash).commit(&calibration(mark), false).is_ok();
                ((Some(mark), now), done)
            } else {
                let result = slots(&mut flash).roll_back();
                assert!(
                    cut.is_some() || result.is_ok() == older.is_some(),
                    "{result:?}"
                );
                ((older, None), result.is_ok())
            };
            flash.power_up();
            let found = in_force(&mut flash);
            if done {
                assert_eq!(found, after.0, "seed {seed}, {number}");
                (now, older) = after;
                rolled += u32::from(!commit);
            } else {
                cuts += u32::from(cut.is_some());
                assert!(
                    found == now || found == after.0,
                    "seed {seed}, {number}: {found:?}"
                );
                // A commit that was cut off may have cost the older one; a roll back may be done all the same.
                older = if found == now {
                    list_older(&mut flash)
                } else {
                    after.1
                };
                now = found;
            }
            assert_eq!(list_older(&mut flash), older, "seed {seed}, {number}");
        }
    }
    assert!(
        cuts > 100 && rolled > 100,
        "{cuts} cuts, {rolled} roll backs"
    );
}

/// Mark of the record that a roll back would bring in force.
fn list_older(flash: &mut Flash) -> Option<f32> {
    let older = slots(flash)
        .list()
        .into_iter()
        .find(|info| info.state == SlotState::Older)?;
    let calibration = slots(flash).read(older.slot).unwrap().1;
    Some(calibration.made.uptime_s as f32)
}
