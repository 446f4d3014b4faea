//! The log of the board's story on the simulated flash.

mod layout;
mod power_cuts;
mod ring;

use courier_sensor::calibration::record::Instant;
use courier_sensor::event_log::entry::{Event, Head, Read, decode};
use courier_sensor::event_log::page::Page;
use courier_sensor::event_log::store::{EventLog, NotWritten};
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

/// Pages of the log; one that is not ours lies before it and one behind.
const PAGES: usize = 4;

fn flash(seed: u64) -> Flash {
    Flash::new(PAGES + 2, seed)
}

fn log(flash: &mut Flash) -> EventLog<'_, Flash> {
    let start = PAGE_BYTES as u32;
    EventLog::new(flash, start..start + (PAGES * PAGE_BYTES) as u32)
}

fn head(number: u32) -> Head {
    Head {
        number,
        start: 1,
        time: Instant {
            unix_s: Some(1_800_000_000),
            uptime_s: number,
        },
    }
}

/// An entry that tells its number by its event as well.
fn append(flash: &mut Flash, number: u32) -> Result<(), NotWritten> {
    log(flash).append(&head(number), &Event::Status(number))
}

/// Numbers of whole entries, in the order that they are read in; and bytes that belong to none.
fn read(flash: &mut Flash) -> (Vec<u32>, u16) {
    let mut numbers = Vec::new();
    loop {
        let mut page = Page::default();
        log(flash).page(numbers.len() as u16, &mut page);
        for entry in page.entries() {
            match decode(entry) {
                Some(Read::Known(head, Event::Status(number))) => {
                    assert_eq!(head, self::head(number));
                    numbers.push(number);
                }
                other => panic!("{other:?}"),
            }
        }
        if !page.more {
            return (numbers, page.damaged_bytes);
        }
    }
}
