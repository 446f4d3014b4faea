//! A ring that is never full, and what is read of one that is damaged.

use super::{PAGES, append, flash, head, log, read};
use courier_sensor::event_log::entry::{Event, LAYOUT, Read, decode};
use courier_sensor::event_log::page::Page;
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

#[test]
fn the_oldest_page_goes_when_the_last_is_full_and_pages_wear_alike() {
    let mut flash = flash(1);
    let entries = 1000;
    for number in 1..=entries {
        append(&mut flash, number).unwrap();
        let (numbers, damaged_bytes) = read(&mut flash);
        assert_eq!(numbers.last(), Some(&number));
        assert!(
            numbers.windows(2).all(|pair| pair[1] == pair[0] + 1),
            "no gap"
        );
        assert_eq!(damaged_bytes, 0);
        assert_eq!(log(&mut flash).end().last, head(number));
    }
    let (numbers, _) = read(&mut flash);
    // An entry of so many bytes behind a head of 8, whole double words; a mark at either end of a page.
    let one = (PAGE_BYTES - 16) / (8 + 16);
    assert!(
        numbers.len() > (PAGES - 1) * one && numbers.len() <= PAGES * one,
        "{}",
        numbers.len()
    );
    let outside = [
        0..PAGE_BYTES,
        (PAGES + 1) * PAGE_BYTES..(PAGES + 2) * PAGE_BYTES,
    ];
    for outside in outside {
        assert!(flash.bytes()[outside].iter().all(|byte| *byte == 0xFF));
    }
}

#[test]
fn a_damaged_entry_is_counted_and_skipped() {
    let mut flash = flash(2);
    (1..=5).for_each(|number| append(&mut flash, number).unwrap());
    let entry = 24;
    // A bit of the third entry's data, and of the fourth one's head.
    for place in [
        PAGE_BYTES + 8 + 2 * entry + 12,
        PAGE_BYTES + 8 + 3 * entry + 5,
    ] {
        let byte = flash.bytes()[place] ^ 0x10;
        flash.force(place, &[byte]);
    }
    let (numbers, damaged_bytes) = read(&mut flash);
    assert_eq!(numbers, [1, 2, 5]);
    assert_eq!(usize::from(damaged_bytes), 2 * entry);
    append(&mut flash, 6).unwrap();
    assert_eq!(read(&mut flash).0, [1, 2, 5, 6]);
}

#[test]
fn an_entry_of_another_layout_is_named_and_its_number_counts() {
    let mut flash = flash(3);
    let mut bytes = [0; courier_sensor::event_log::entry::ENTRY_BYTES];
    let entry = courier_sensor::event_log::entry::encode(&head(7), &Event::Status(1), &mut bytes);
    let mut entry = entry.unwrap().to_vec();
    entry[0] = LAYOUT + 1;
    entry.truncate(entry.len() - 1);
    let read = decode(&entry).unwrap();
    let layout = LAYOUT + 1;
    assert_eq!(
        read,
        Read::Other {
            head: head(7),
            layout
        }
    );
    // As another firmware leaves it in flash: the ring is the same.
    append(&mut flash, 1).unwrap();
    let place = PAGE_BYTES + 8 + 8;
    let mut other = flash.bytes()[place..place + 16].to_vec();
    other[0] = layout;
    let log_range = PAGE_BYTES as u32..(PAGES as u32 + 1) * PAGE_BYTES as u32;
    let mut raw = Flash::new(PAGES + 2, 3);
    push_raw(&mut raw, log_range, &other);
    let mut page = Page::default();
    log(&mut raw).page(0, &mut page);
    let kept: Vec<Read> = page.entries().filter_map(decode).collect();
    assert_eq!(
        kept,
        [Read::Other {
            head: head(1),
            layout
        }]
    );
    assert_eq!(log(&mut raw).end().last, head(1));
}

/// By the ring itself, as another firmware would.
fn push_raw(flash: &mut Flash, region: core::ops::Range<u32>, bytes: &[u8]) {
    assert_eq!(flash_ring::push(flash, &region, bytes), Ok(()));
}

#[test]
fn a_flash_that_no_longer_erases_keeps_what_it_has() {
    let mut flash = flash(4);
    let full = (1..).find(|number| {
        if *number == 2 {
            flash.wear_out();
        }
        append(&mut flash, *number).is_err()
    });
    let full = full.unwrap();
    let (numbers, _) = read(&mut flash);
    assert_eq!(numbers, (1..full).collect::<Vec<_>>());
}

#[test]
fn whatever_bytes_there_are_the_next_entry_is_written() {
    use rand::{RngExt, SeedableRng};
    for seed in 0..200 {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut flash = flash(seed);
        for page in 1..=PAGES {
            let kind: u32 = random.random_range(0..4);
            let mut bytes: Vec<u8> = (0..PAGE_BYTES).map(|_| random.random()).collect();
            match kind {
                0 => continue,
                1 => bytes.fill(0),
                // A page's marks as of one that is closed, or partly written.
                2 => bytes[..8].fill(0),
                _ => {}
            }
            flash.force(page * PAGE_BYTES, &bytes);
        }
        append(&mut flash, 1).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(read(&mut flash).0.contains(&1), "seed {seed}");
    }
}
