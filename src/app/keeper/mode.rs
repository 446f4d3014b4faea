//! What becomes of a recalibration's candidates, as a setting that is kept: behind the calibration's record, at the end of its page.
//!
//! ```text
//! | mode, 1 B | inverse of it, 1 B | zero, 2 B | CRC-32 of these 4 bytes |
//! ```
//! A change is one double word, the last whole one counts. It goes with the record: where another calibration comes in force the setting is
//! written behind that too, and until then the other slot's tells it. The new bank of an update takes it over with the slots.

use super::Keeper;
use super::entries;
use crate::calibration::recalibration::Mode;
use crate::calibration::slots::SLOTS;
use core::ops::Range;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embedded_storage::nor_flash::NorFlash;

static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
const WORD: usize = 8;
/// Changes of the setting that there is room for behind a calibration.
pub const CHANGES: usize = 16;
/// Bytes of them.
pub(super) const MODE_BYTES: usize = CHANGES * WORD;

impl<F: NorFlash> Keeper<'_, '_, F> {
    /// The setting, as it was kept with the stored calibration in force, or with the other one.
    #[inline(never)]
    pub fn mode(&mut self) -> Mode {
        let first = self.stored.map_or(0, |place| place.slot);
        let slots = (0..SLOTS as u8).map(|i| (first + i) % SLOTS as u8);
        let mut kept = slots.filter_map(|slot| {
            let room = self.slots.room_behind(slot)?;
            last(self.slots.flash_mut(), &room)
        });
        kept.next().unwrap_or_default()
    }

    /// Keeps it with the stored calibration in force, if that has another; false if there is no such calibration, no room, or the flash does
    /// not take it.
    #[inline(never)]
    pub fn keep_mode(&mut self, mode: Mode) -> bool {
        let stored = self.stored;
        let Some(room) = stored.and_then(|place| self.slots.room_behind(place.slot)) else {
            return false;
        };
        let flash = self.slots.flash_mut();
        last(flash, &room) == Some(mode) || add(flash, &room, mode)
    }
}

/// The last whole one.
pub fn last<F: NorFlash>(flash: &mut F, room: &Range<u32>) -> Option<Mode> {
    entries::last(flash, &words(room), from_bytes)
}

/// Adds one; whether there was room and the flash took it.
pub fn add<F: NorFlash>(flash: &mut F, room: &Range<u32>, mode: Mode) -> bool {
    entries::add(flash, &words(room), &to_bytes(mode))
}

fn words(room: &Range<u32>) -> Range<u32> {
    room.end.saturating_sub(MODE_BYTES as u32).max(room.start)..room.end
}

fn to_bytes(mode: Mode) -> [u8; WORD] {
    let byte = match mode {
        Mode::Off => 1,
        Mode::Propose => 2,
        Mode::Automatic => 3,
    };
    let head = [byte, !byte, 0, 0];
    let [a, b, c, d] = CRC32.checksum(&head).to_le_bytes();
    [byte, !byte, 0, 0, a, b, c, d]
}

fn from_bytes(bytes: &[u8; WORD]) -> Option<Mode> {
    let modes = [Mode::Off, Mode::Propose, Mode::Automatic];
    modes.into_iter().find(|mode| to_bytes(*mode) == *bytes)
}
