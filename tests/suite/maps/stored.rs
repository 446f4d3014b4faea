//! What the slots keep, refuse and leave alone.

use super::{OWNER, START, contents, current, flash, header, info, maps, model, nodes, store};
use courier_sensor::device::Device;
use courier_sensor::maps::{MapRecordError, MapSlotState, MapStoreError, Maps};
use hal_sim::wire::flash::PAGE_BYTES;

#[test]
fn three_places_keep_their_newest_map_and_a_fourth_is_refused() {
    let mut flash = flash(1);
    for mark in 1..40 {
        let name = ["a", "b", "c"][mark as usize % 3];
        let slot = store(&mut flash, name, mark).unwrap();
        let found = contents(&mut flash, START, slot);
        assert_eq!(found, (model(mark), header(), nodes(mark)));
    }
    let all = [("a", 39), ("b", 37), ("c", 38)].map(|(name, mark)| (name.to_owned(), mark));
    assert_eq!(current(&mut flash), all);
    assert_eq!(store(&mut flash, "d", 40), Err(MapStoreError::Full));
    assert_eq!(current(&mut flash), all);
    let of_b = (0..4).find(|slot| {
        let found = maps(&mut flash).current(*slot);
        found.is_some_and(|found| found.info.name == "b")
    });
    let slot = of_b.unwrap();
    maps(&mut flash).forget(slot).unwrap();
    assert_eq!(
        maps(&mut flash).slot(slot).unwrap().state,
        MapSlotState::Forgotten
    );
    store(&mut flash, "d", 40).unwrap();
    let names: Vec<String> = current(&mut flash)
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    assert_eq!(names, ["a", "c", "d"]);
}

#[test]
fn an_older_map_counts_again_when_the_newer_decays() {
    let mut flash = flash(2);
    store(&mut flash, "a", 1).unwrap();
    let newer = store(&mut flash, "a", 2).unwrap();
    assert_eq!(current(&mut flash), [("a".to_owned(), 2)]);
    assert_eq!(
        maps(&mut flash).slot(1 - newer).unwrap().state,
        MapSlotState::Older
    );
    let place = PAGE_BYTES + usize::from(newer) * 4096 + 2000;
    flash.force(place - 2000 + 200, &[0x5A; 8]);
    let torn = MapSlotState::Refused(MapRecordError::Torn);
    assert_eq!(maps(&mut flash).slot(newer).unwrap().state, torn);
    assert_eq!(current(&mut flash), [("a".to_owned(), 1)]);
}

#[test]
fn another_boards_map_is_named_and_does_not_count() {
    let mut flash = flash(3);
    let slot = store(&mut flash, "a", 1).unwrap();
    let mut others = Maps::new(&mut flash, PAGE_BYTES as u32, Device(*b"board-000002"));
    assert_eq!(
        others.examine(slot),
        Err(MapRecordError::OtherDevice(OWNER))
    );
    assert!(others.current(slot).is_none());
}

#[test]
fn a_later_firmwares_map_is_named_and_left_alone() {
    let mut flash = flash(4);
    let slot = store(&mut flash, "a", 1).unwrap();
    // Its version, and the check that goes with it.
    let start = PAGE_BYTES + usize::from(slot) * 4096;
    let mut head: [u8; 24] = flash.bytes()[start..start + 24].try_into().unwrap();
    head[4] = 2;
    let words = |bytes: u16| u32::from(bytes).next_multiple_of(8) as usize;
    let body = words(u16::from_le_bytes([head[6], head[7]])) + words(2 * 70);
    let covered = [&head[..16], &flash.bytes()[start + 24..][..body]].concat();
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&covered);
    head[16..20].copy_from_slice(&crc.to_le_bytes());
    head[20..].copy_from_slice(&(!crc).to_le_bytes());
    flash.force(start, &head);
    let unknown = MapSlotState::Refused(MapRecordError::UnknownVersion(2));
    assert_eq!(maps(&mut flash).slot(slot).unwrap().state, unknown);
    for mark in 2..12 {
        store(&mut flash, ["b", "c"][mark as usize % 2], mark).unwrap();
    }
    assert_eq!(store(&mut flash, "d", 12), Err(MapStoreError::Full));
    assert_eq!(maps(&mut flash).slot(slot).unwrap().state, unknown);
}

#[test]
fn a_flash_that_fails_is_named() {
    let mut flash = flash(5);
    store(&mut flash, "a", 1).unwrap();
    flash.wear_out();
    assert_eq!(store(&mut flash, "a", 2), Err(MapStoreError::Erase(1)));
    assert_eq!(current(&mut flash), [("a".to_owned(), 1)]);
    let mut maps = maps(&mut flash);
    assert_eq!(maps.forget(7), Err(MapStoreError::NoSuchSlot(7)));
    let error = MapRecordError::Empty;
    assert_eq!(
        maps.forget(2),
        Err(MapStoreError::Record { slot: 2, error })
    );
}

#[test]
fn numbers_that_no_map_has_are_refused() {
    for wrong in [
        courier_sensor::maps::MapInfo {
            parity_m: f32::NAN,
            ..info("a", 1)
        },
        courier_sensor::maps::MapInfo {
            name: "two words".try_into().unwrap(),
            ..info("a", 1)
        },
        courier_sensor::maps::MapInfo {
            name: "".try_into().unwrap(),
            ..info("a", 1)
        },
    ] {
        assert_eq!(wrong.validate(), Err(MapRecordError::Invalid));
    }
    let mut wrong = info("a", 1);
    wrong.anchor.height_m = 0.0;
    assert_eq!(wrong.validate(), Err(MapRecordError::Invalid));
}
