//! Calibration slots on the simulated flash: the power may go at any step, nothing committed is lost.

use courier_sensor::calibration::record::{
    self, Calibration, Instant, MAX_BYTES, RecordError, VERSION,
};
use courier_sensor::calibration::slots::{Place, SLOT_BYTES, SlotError, SlotState, Slots};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Term, TermTable};
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

/// A calibration like a joint one's, told apart by `mark`.
fn calibration(mark: f32) -> Calibration {
    let terms = [1, 2, 4, 6]
        .map(Term::own)
        .into_iter()
        .chain([Term::lateral(1)]);
    let mut table = TermTable::default();
    terms.for_each(|term| table.push(term).unwrap());
    let mut model = ErrorModel::zero(table);
    model.constants_m = [
        0.25e-6 * mark,
        -0.25e-6 * mark,
        -0.25e-6 * mark,
        0.25e-6 * mark,
    ];
    model
        .coefficients
        .iter_mut()
        .flatten()
        .flatten()
        .enumerate()
        .for_each(|(n, k)| *k = 1.0e-6 * mark + n as f32 * 1.0e-8);
    Calibration {
        device: *b"board-000001",
        made: Instant {
            unix_s: Some(1_700_000_000),
            uptime_s: mark as u32,
        },
        temperature_c: 24.5,
        amplitude_counts: [20_000.0; 4],
        model,
        ..Calibration::identity(Geometry::PAPER)
    }
}

fn slots(flash: &mut Flash) -> Slots<&mut Flash> {
    Slots::new(flash, PAGE_BYTES as u32)
}

fn in_force(flash: &mut Flash) -> Option<f32> {
    let loaded = slots(flash).load().ok()?;
    Some(loaded.1.made.uptime_s as f32)
}

/// Three pages: one that is not ours before the slots.
fn flash(seed: u64) -> Flash {
    Flash::new(3, seed)
}

#[test]
fn commits_alternate_and_the_newest_is_in_force() {
    let mut flash = flash(1);
    assert_eq!(slots(&mut flash).load(), Err(SlotError::NoneInForce));
    for number in 1..=5 {
        let place = slots(&mut flash)
            .commit(&calibration(number as f32), false)
            .unwrap();
        assert_eq!(
            place,
            Place {
                slot: (number as u8 + 1) % 2,
                sequence: number
            }
        );
        assert_eq!(
            slots(&mut flash).load(),
            Ok((place, calibration(number as f32)))
        );
    }
    let list = slots(&mut flash).list();
    assert_eq!(
        (list[0].state, list[0].sequence),
        (SlotState::InForce, Some(5))
    );
    assert_eq!(
        (list[1].state, list[1].sequence),
        (SlotState::Older, Some(4))
    );
    assert!(
        flash.bytes()[..PAGE_BYTES].iter().all(|&byte| byte == 0xFF),
        "the page before is not ours"
    );
}

#[test]
fn roll_back_and_commit_again() {
    let mut flash = flash(1);
    let mut both = slots(&mut flash);
    both.commit(&calibration(1.0), false).unwrap();
    assert_eq!(both.roll_back(), Err(SlotError::NothingOlder));
    both.commit(&calibration(2.0), false).unwrap();
    assert_eq!(
        both.roll_back(),
        Ok(Place {
            slot: 0,
            sequence: 1
        })
    );
    assert_eq!(both.load().unwrap().1, calibration(1.0));
    assert_eq!(
        both.read(1).unwrap().1,
        calibration(2.0),
        "rolled back, but still to be read"
    );
    assert_eq!(both.list()[1].state, SlotState::RolledBack);
    assert_eq!(both.roll_back(), Err(SlotError::NothingOlder));
    assert_eq!(
        both.commit(&calibration(3.0), false),
        Ok(Place {
            slot: 1,
            sequence: 3
        })
    );
    assert_eq!(both.load().unwrap().1, calibration(3.0));
    assert_eq!(both.read(2).unwrap_err(), SlotError::NoSuchSlot { slot: 2 });
}

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

fn commit(mark: f32) -> impl Fn(&mut Flash) {
    move |flash| {
        let _ = slots(flash).commit(&calibration(mark), false);
    }
}

#[test]
fn a_cut_at_any_step_of_the_first_commit_leaves_none_or_the_new_one() {
    cut_everywhere(|_| (), commit(1.0), [None, Some(1.0)]);
}

#[test]
fn a_cut_at_any_step_of_a_later_commit_leaves_the_old_or_the_new_one() {
    cut_everywhere(commit(1.0), commit(2.0), [Some(1.0), Some(2.0)]);
    let two = |flash: &mut Flash| {
        commit(1.0)(flash);
        commit(2.0)(flash);
    };
    cut_everywhere(two, commit(3.0), [Some(2.0), Some(3.0)]);
}

#[test]
fn a_cut_at_any_step_of_a_roll_back_leaves_one_of_both_in_force() {
    let two = |flash: &mut Flash| {
        commit(1.0)(flash);
        commit(2.0)(flash);
    };
    cut_everywhere(
        two,
        |flash| {
            let _ = slots(flash).roll_back();
        },
        [Some(2.0), Some(1.0)],
    );
}

#[test]
fn both_slots_torn_is_none_in_force_and_said() {
    let mut flash = flash(1);
    commit(1.0)(&mut flash);
    commit(2.0)(&mut flash);
    for slot in 0..2 {
        flash.force(PAGE_BYTES + slot * SLOT_BYTES + 40, &[0; 8]);
    }
    assert_eq!(slots(&mut flash).load(), Err(SlotError::NoneInForce));
    for info in slots(&mut flash).list() {
        assert_eq!(info.state, SlotState::Refused(RecordError::Torn));
    }
    assert!(slots(&mut flash).commit(&calibration(3.0), false).is_ok());
}

/// The record in a slot as a firmware with another layout version would have written it.
fn age(flash: &mut Flash, slot: usize, version: u16) {
    let start = PAGE_BYTES + slot * SLOT_BYTES;
    let mut record = flash.bytes()[start..start + MAX_BYTES].to_vec();
    let length = 16 + u32::from_le_bytes(record[8..12].try_into().unwrap()) as usize;
    record[4..6].copy_from_slice(&version.to_le_bytes());
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&record[..length]);
    record[length..length + 4].copy_from_slice(&crc.to_le_bytes());
    flash.force(start, &record);
}

#[test]
fn an_unknown_version_is_refused_said_and_kept() {
    let mut flash = flash(1);
    commit(1.0)(&mut flash);
    commit(2.0)(&mut flash);
    age(&mut flash, 1, VERSION + 1);
    let version = VERSION + 1;
    let mut both = slots(&mut flash);
    assert_eq!(
        both.load().unwrap().1,
        calibration(1.0),
        "the newest that is known"
    );
    assert_eq!(
        both.list()[1].state,
        SlotState::Refused(RecordError::UnknownVersion { version })
    );
    assert_eq!(
        both.read(1).unwrap_err(),
        SlotError::Record(RecordError::UnknownVersion { version })
    );
    let refusal = both.commit(&calibration(3.0), false).unwrap_err();
    assert_eq!(refusal, SlotError::WouldLoseUnknown { slot: 1, version });
    assert_eq!(
        refusal.to_string(),
        format!(
            "slot 1 holds layout version {}, not known here: it is overwritten only when told to",
            record::VERSION + 1
        )
    );
    assert_eq!(
        both.commit(&calibration(3.0), true),
        Ok(Place {
            slot: 1,
            sequence: 3
        })
    );
    age(&mut flash, 0, 0);
    age(&mut flash, 1, 77);
    let refusal = slots(&mut flash).load().unwrap_err().to_string();
    assert_eq!(
        refusal,
        format!(
            "record: layout version 0 is not known here, this firmware reads {}",
            record::VERSION
        )
    );
}

#[test]
fn every_flipped_bit_of_a_record_is_noticed() {
    let mut buffer = [0; MAX_BYTES];
    let length = record::encode(&calibration(1.0), 7, &mut buffer).unwrap();
    assert_eq!(record::decode(&buffer), Ok((7, calibration(1.0))));
    for bit in 0..8 * length {
        buffer[bit / 8] ^= 1 << (bit % 8);
        assert!(record::decode(&buffer).is_err(), "bit {bit}");
        buffer[bit / 8] ^= 1 << (bit % 8);
    }
    for end in 0..length {
        assert!(record::decode(&buffer[..end]).is_err(), "{end} bytes");
    }
}

#[test]
fn numbers_that_cannot_be_used_are_neither_written_nor_read() {
    let mut flash = flash(1);
    let mut bad = calibration(1.0);
    bad.geometry.span_m = f32::NAN;
    let refusal = slots(&mut flash).commit(&bad, false).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "record: geometry is not a finite number"
    );
    let mut bad = calibration(1.0);
    bad.model.coefficients.pop();
    assert!(matches!(
        slots(&mut flash).commit(&bad, false),
        Err(SlotError::Record(RecordError::Model(_)))
    ));
    assert_eq!(flash.steps(), 0, "nothing was erased or written");
}

#[test]
fn the_fullest_record_fits() {
    let mut fullest = calibration(1.0);
    let every = (1..=16).flat_map(|own| {
        (-4..=4).map(move |lateral| Term {
            own_order: own,
            lateral_order: lateral,
            ..Term::default()
        })
    });
    fullest.model.terms = TermTable::default();
    for term in every {
        let _ = fullest.model.terms.push(term);
    }
    fullest.model.coefficients.clear();
    while fullest.model.coefficients.push([[999.0; 2]; 4]).is_ok() {}
    fullest.beacon = Some(record::Beacon {
        origin_teeth: [i32::MAX; 2],
        origin_m: [1.0; 2],
        sensor: [1.0; 16],
        segment_sd_m: 1.0e-6,
        displacement_sd_m: 1.0e-6,
    });
    let mut buffer = [0; MAX_BYTES];
    let length = record::encode(&fullest, u32::MAX, &mut buffer).unwrap();
    assert!(length < MAX_BYTES, "{length}");
    println!("fullest record: {length} of {MAX_BYTES} bytes");
}

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

proptest::proptest! {
    #[test]
    fn any_record_round_trips(
        sequence in proptest::num::u32::ANY,
        coefficients in proptest::collection::vec(-1.0e3f32..1.0e3, 0..192),
        device in proptest::array::uniform12(0u8..),
        unix_s in proptest::option::of(0u64..),
        temperature_c in -50.0f32..150.0,
    ) {
        let mut calibration = calibration(1.0);
        calibration.device = device;
        calibration.made.unix_s = unix_s;
        calibration.temperature_c = temperature_c;
        let slots = calibration.model.coefficients.iter_mut().flatten().flatten();
        slots.zip(&coefficients).for_each(|(slot, value)| *slot = *value);
        let mut buffer = [0; MAX_BYTES];
        let length = record::encode(&calibration, sequence, &mut buffer).unwrap();
        proptest::prop_assert_eq!(record::decode(&buffer[..length]), Ok((sequence, calibration)));
    }

    #[test]
    fn bytes_of_any_kind_never_panic_and_never_pass(mut bytes in proptest::collection::vec(0u8.., 0..200), header in 0u8..3) {
        if header > 0 && bytes.len() >= 16 {
            bytes[..8].copy_from_slice(b"CSRC\x01\0\0\0");
            let body = (bytes.len() - 16) as u32;
            bytes[8..12].copy_from_slice(&body.saturating_sub(4 * u32::from(header - 1)).to_le_bytes());
        }
        proptest::prop_assert!(record::decode(&bytes).is_err());
    }
}
