//! Entries of one length that follow each other in a place of the flash, in what an erase has left: the last whole one counts, and none is
//! erased for the next. A write that was cut short leaves an entry that does not count, and takes one place.

use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

/// Bytes of the longest entry.
const MOST_BYTES: usize = 96;

/// The last entry in `room` that `parse` takes for one.
pub fn last<F: NorFlash, T, const N: usize>(
    flash: &mut F,
    room: &Range<u32>,
    parse: impl Fn(&[u8; N]) -> Option<T>,
) -> Option<T> {
    const { assert!(N <= MOST_BYTES, "an entry fits its buffer") };
    let mut last = None;
    each(flash, room, N, &mut |bytes| {
        let bytes = <&[u8; N]>::try_from(bytes).ok();
        last = bytes.and_then(&parse).or(last.take());
    });
    last
}

/// Gives the bytes of every place that can be read to `take`, in order. One copy for all kinds of entries.
#[inline(never)]
fn each<F: NorFlash>(
    flash: &mut F,
    room: &Range<u32>,
    entry_bytes: usize,
    take: &mut dyn FnMut(&[u8]),
) {
    let mut bytes = [0; MOST_BYTES];
    let bytes = &mut bytes[..entry_bytes.min(MOST_BYTES)];
    for place in places(room, entry_bytes) {
        if flash.read(place, bytes).is_ok() {
            take(bytes);
        }
    }
}

/// Adds an entry behind the last place that anything was written to, so that nothing is programmed twice; whether there was room and the
/// flash took it.
#[inline(never)]
pub fn add<F: NorFlash>(flash: &mut F, room: &Range<u32>, entry: &[u8]) -> bool {
    let mut free = None;
    for place in places(room, entry.len()).rev() {
        let mut bytes = [0; MOST_BYTES];
        let bytes = &mut bytes[..entry.len().min(MOST_BYTES)];
        if flash.read(place, bytes).is_err() || bytes.iter().any(|byte| *byte != 0xFF) {
            break;
        }
        free = Some(place);
    }
    free.is_some_and(|place| flash.write(place, entry).is_ok())
}

fn places(room: &Range<u32>, entry_bytes: usize) -> impl DoubleEndedIterator<Item = u32> + use<> {
    let entry_bytes = entry_bytes.max(1) as u32;
    let (start, entries) = (room.start, (room.end - room.start) / entry_bytes);
    (0..entries).map(move |entry| start + entry * entry_bytes)
}
