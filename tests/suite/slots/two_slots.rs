//! Which of the two slots is written, read, in force, or refused.

use super::{calibration, commit, flash, slots};
use courier_sensor::calibration::record::{self, MAX_BYTES, RecordError, VERSION};
use courier_sensor::calibration::slots::{Place, SLOT_BYTES, SlotError, SlotState};
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

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

/// As a firmware before wrote it: a record of version 2 ends before the poses, of which one that knows none holds a byte.
#[test]
fn a_record_of_version_2_is_read_and_names_no_poses() {
    let mut flash = flash(1);
    commit(1.0)(&mut flash);
    let start = PAGE_BYTES;
    let mut record = flash.bytes()[start..start + MAX_BYTES].to_vec();
    let length = u32::from_le_bytes(record[8..12].try_into().unwrap()) - 1;
    record[8..12].copy_from_slice(&length.to_le_bytes());
    flash.force(start, &record);
    age(&mut flash, 0, 2);
    let (_, read) = slots(&mut flash).load().unwrap();
    assert_eq!((read.poses, &read), (None, &calibration(1.0)));
    // The same bytes as a version that has poses are none.
    age(&mut flash, 0, VERSION);
    assert!(slots(&mut flash).load().is_err());
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
            "record: layout version 0 is not known here, this firmware reads {} to {}",
            record::OLDEST_VERSION,
            record::VERSION
        )
    );
}
