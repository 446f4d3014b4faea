//! What the watch over a calibration lets frames say, and what it keeps in flash: behind the calibration's record, in the page of its slot.
//!
//! Entries of [`KEPT_BYTES`] follow each other, of the watch over the segments and of those over rests; the last whole one of each
//! counts. A page has room for nine, and none is erased for them: they go
//! with the calibration. A write that was cut short leaves an entry that does not count, and takes one place.

use super::Keeper;
use super::entries;
use super::mode::MODE_BYTES;
use crate::calibration::rest_watch::{RestKept, RestKind};
use crate::calibration::watch::{KEPT_BYTES, Kept};
use crate::link::message::Refusal;
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash> Keeper<'_, '_, F> {
    /// Lets frames say, from the next sample on, that the calibration in force has drifted, or no longer.
    ///
    /// # Errors
    /// [`Refusal::SwapBusy`]: to be tried again.
    pub fn say_drifted(&mut self, drifted: bool) -> Result<(), Refusal> {
        let before = self.settings.drifted;
        self.settings.drifted = drifted;
        let built = self.build();
        let sent = built.and_then(|()| self.swap.send().map_err(|_| Refusal::SwapBusy));
        sent.inspect_err(|_| self.settings.drifted = before)
    }

    /// Whether frames say so.
    pub fn says_drifted(&self) -> bool {
        self.settings.drifted
    }

    /// The last entry of the stored calibration in force, of the same kind of outputs: with a tooth map, or without.
    #[inline(never)]
    pub fn kept(&mut self) -> Option<Kept> {
        let with_map = self.map().is_some();
        self.last_kept(|bytes| Kept::from_bytes(bytes, with_map))
    }

    /// The same of a watch over rests.
    pub fn kept_of_rests(&mut self, kind: RestKind) -> Option<RestKept> {
        let with_map = self.map().is_some();
        self.last_kept(|bytes| RestKept::from_bytes(bytes, kind, with_map))
    }

    fn last_kept<T>(&mut self, parse: impl Fn(&[u8; KEPT_BYTES]) -> Option<T>) -> Option<T> {
        let room = self.slots.room_behind(self.stored?.slot)?;
        last(self.slots.flash_mut(), &room, parse)
    }

    /// Adds an entry, if the calibration in force is stored and there is room; whether it was added.
    #[inline(never)]
    pub fn keep(&mut self, kept: &Kept) -> bool {
        let bytes = kept.bytes(self.map().is_some());
        self.keep_bytes(&bytes)
    }

    /// The same of a watch over rests.
    pub fn keep_of_rests(&mut self, kind: RestKind, kept: &RestKept) -> bool {
        let bytes = kept.bytes(kind, self.map().is_some());
        self.keep_bytes(&bytes)
    }

    #[inline(never)]
    fn keep_bytes(&mut self, bytes: &[u8; KEPT_BYTES]) -> bool {
        let stored = self.stored;
        let room = stored.and_then(|place| self.slots.room_behind(place.slot));
        room.is_some_and(|room| add(self.slots.flash_mut(), &room, bytes))
    }

    /// Whether the calibration in force is stored: otherwise nothing is kept of it.
    pub fn is_stored(&self) -> bool {
        self.stored.is_some()
    }
}

/// The last entry in a place of the flash that `parse` takes for one.
pub fn last<F: NorFlash, T>(
    flash: &mut F,
    room: &Range<u32>,
    parse: impl Fn(&[u8; KEPT_BYTES]) -> Option<T>,
) -> Option<T> {
    entries::last(flash, &before_modes(room), parse)
}

/// Adds an entry; whether there was room and the flash took it.
pub fn add<F: NorFlash>(flash: &mut F, room: &Range<u32>, entry: &[u8; KEPT_BYTES]) -> bool {
    entries::add(flash, &before_modes(room), entry)
}

fn before_modes(room: &Range<u32>) -> Range<u32> {
    room.start..room.end.saturating_sub(MODE_BYTES as u32).max(room.start)
}
