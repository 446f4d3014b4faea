//! What is stored moves with the image: both calibration slots, the tooth maps and the log, from the bank that code now runs from into the one that it
//! may write.
//!
//! Until a new image is accepted, what lies beside it is in force: the old image goes on with that if the new one is refused. So the copy
//! is made at every start on trial, and nothing is stored before the image was accepted. Slots that hold the same already are left alone.

use super::layout::{LOG_END, LOG_START, MAPS_START, SLOTS_START, WORD_BYTES};
use crate::calibration::slots::{self, Slots};
use crate::device::Device;
use crate::maps::{self, Maps};
use core::ops::Range;
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

const WORD: usize = WORD_BYTES as usize;
const ERASED: [u8; WORD] = [0xFF; WORD];
/// In place of a double word that cannot be read. In a record it makes the check value wrong; as the mark of a slot that was taken out of
/// use it says that it was: both as before.
const UNREADABLE: [u8; WORD] = [0; WORD];

/// The flash does not hold what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the calibration cannot be moved into the other bank")]
pub struct MirrorError;

/// Makes the slots in `far`, the bank that may be written, those in `near`, the bank that code runs from, if those are in force: on trial
/// always, otherwise if they hold the higher number, as after a bank was written by a debug probe. Whether anything was written.
///
/// # Errors
/// [`MirrorError`]; `near` is untouched, whatever happens.
pub fn mirror<N: NorFlash, F: NorFlash>(
    near: &mut N,
    far: &mut F,
    on_trial: bool,
) -> Result<bool, MirrorError> {
    let numbers = numbers(near);
    let [first, second] = [0, 1].map(calibration_slot);
    // The newest last: a copy that was cut short does not pass for a whole one.
    let newest_last = match numbers[0] > numbers[1] {
        true => [second, first],
        false => [first, second],
    };
    let is_due = on_trial || newest(&numbers) > newest(&self::numbers(far));
    let moved = move_slots(near, far, is_due, &newest_last)?;
    let newest_map = newest_map(near);
    let is_due = on_trial || newest_map.map(number) > self::newest_map(far).map(number);
    let last = newest_map.map_or(0, |(_, slot)| u32::from(slot));
    let maps = [1, 2, 3, 4].map(|behind| map_slot((last + behind) % maps::SLOTS as u32));
    let moved = move_slots(near, far, is_due, &maps)? || moved;
    // The story goes on where it was; without it the image works as well.
    let log = LOG_START..LOG_END;
    let log = core::slice::from_ref(&log);
    Ok(move_slots(near, far, on_trial, log).unwrap_or(false) || moved)
}

/// Makes these places in `far` those in `near`. Whether anything was written.
#[inline(never)]
fn move_slots<N: NorFlash, F: NorFlash>(
    near: &mut N,
    far: &mut F,
    is_due: bool,
    places: &[Range<u32>],
) -> Result<bool, MirrorError> {
    let mut moved = false;
    for place in places.iter().filter(|_| is_due) {
        if !is_same(near, far, place) {
            copy(near, far, place).map_err(|_| MirrorError)?;
            moved = true;
        }
    }
    match !moved || places.iter().all(|place| is_same(near, far, place)) {
        true => Ok(moved),
        false => Err(MirrorError),
    }
}

fn numbers<F: NorFlash>(flash: &mut F) -> [Option<u32>; slots::SLOTS] {
    Slots::new(flash, SLOTS_START)
        .list()
        .map(|slot| slot.sequence)
}

fn newest(numbers: &[Option<u32>; slots::SLOTS]) -> Option<u32> {
    numbers.iter().copied().flatten().max()
}

fn number((number, _): (u32, u8)) -> u32 {
    number
}

/// The newest map's number and slot; whose maps they are does not matter.
fn newest_map<F: NorFlash>(flash: &mut F) -> Option<(u32, u8)> {
    Maps::new(flash, MAPS_START, Device::default()).newest()
}

fn calibration_slot(slot: u32) -> Range<u32> {
    let start = SLOTS_START + slot * slots::SLOT_BYTES as u32;
    start..start + slots::SLOT_BYTES as u32
}

fn map_slot(slot: u32) -> Range<u32> {
    let start = MAPS_START + slot * maps::SLOT_BYTES;
    start..start + maps::SLOT_BYTES
}

fn words(place: &Range<u32>) -> impl DoubleEndedIterator<Item = u32> + use<> {
    place.clone().step_by(WORD)
}

fn word<F: ReadNorFlash>(flash: &mut F, place: u32) -> [u8; WORD] {
    let mut bytes = ERASED;
    match flash.read(place, &mut bytes) {
        Ok(()) => bytes,
        Err(_) => UNREADABLE,
    }
}

fn is_same<N: ReadNorFlash, F: ReadNorFlash>(
    near: &mut N,
    far: &mut F,
    place: &Range<u32>,
) -> bool {
    words(place).all(|place| word(near, place) == word(far, place))
}

/// The first double words last: without them a map is none, and a calibration torn.
fn copy<N: ReadNorFlash, F: NorFlash>(
    near: &mut N,
    far: &mut F,
    place: &Range<u32>,
) -> Result<(), F::Error> {
    far.erase(place.start, place.end)?;
    for place in words(place).rev() {
        let bytes = word(near, place);
        if bytes != ERASED {
            far.write(place, &bytes)?;
        }
    }
    Ok(())
}
