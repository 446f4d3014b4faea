//! The calibration moves with the image: both slots, from the bank that code now runs from into the one that it may write.
//!
//! Until a new image is accepted, the slots beside it are those in force: the old image goes on with them if the new one is refused. So
//! the copy is made at every start on trial, and nothing is stored before the image was accepted.

use super::layout::{SLOTS_START, WORD_BYTES};
use crate::calibration::slots::{SLOT_BYTES, SLOTS, Slots};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

const WORD: usize = WORD_BYTES as usize;
const ERASED: [u8; WORD] = [0xFF; WORD];
/// In place of a double word that cannot be read. In a record it makes the check value wrong; as the mark of a slot that was rolled
/// back it says that it was: both as before.
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
    let is_due = on_trial || newest(&numbers) > newest(&self::numbers(far));
    let differs = (0..SLOTS).any(|slot| !is_same(near, far, slot));
    if !(is_due && differs) {
        return Ok(false);
    }
    // The newest last: a copy that was cut short does not pass for a whole one.
    let newest_last = if numbers[0] > numbers[1] {
        [1, 0]
    } else {
        [0, 1]
    };
    for slot in newest_last {
        copy(near, far, slot).map_err(|_| MirrorError)?;
    }
    match (0..SLOTS).all(|slot| is_same(near, far, slot)) {
        true => Ok(true),
        false => Err(MirrorError),
    }
}

fn numbers<F: NorFlash>(flash: &mut F) -> [Option<u32>; SLOTS] {
    Slots::new(flash, SLOTS_START)
        .list()
        .map(|slot| slot.sequence)
}

fn newest(numbers: &[Option<u32>; SLOTS]) -> Option<u32> {
    numbers.iter().copied().flatten().max()
}

fn words(slot: usize) -> impl Iterator<Item = u32> {
    let start = SLOTS_START + (slot * SLOT_BYTES) as u32;
    (start..start + SLOT_BYTES as u32).step_by(WORD)
}

fn word<F: ReadNorFlash>(flash: &mut F, place: u32) -> [u8; WORD] {
    let mut bytes = ERASED;
    match flash.read(place, &mut bytes) {
        Ok(()) => bytes,
        Err(_) => UNREADABLE,
    }
}

fn is_same<N: ReadNorFlash, F: ReadNorFlash>(near: &mut N, far: &mut F, slot: usize) -> bool {
    words(slot).all(|place| word(near, place) == word(far, place))
}

fn copy<N: ReadNorFlash, F: NorFlash>(
    near: &mut N,
    far: &mut F,
    slot: usize,
) -> Result<(), F::Error> {
    let start = SLOTS_START + (slot * SLOT_BYTES) as u32;
    far.erase(start, start + SLOT_BYTES as u32)?;
    for place in words(slot) {
        let bytes = word(near, place);
        if bytes != ERASED {
            far.write(place, &bytes)?;
        }
    }
    Ok(())
}
