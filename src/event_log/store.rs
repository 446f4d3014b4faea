//! The log in flash: a ring of pages that sequential-storage levels, the oldest page going when the last is full.
//!
//! A write that was cut short leaves an entry that is skipped. Where the flash refuses a write, as over what an erase has left that was cut
//! short, that page is erased and the write tried once more: the newest entry counts more than a page's old ones. The log holds nothing
//! that anything else depends on.

use super::entry::{ENTRY_BYTES, Event, Head, encode, head};
use super::page::Page;
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use flash_ring::taken_bytes;

/// Tries at writing an entry: a page that refused it, and one that contradicts the others, may have to be erased between.
const ATTEMPTS: u8 = 3;

/// Where the log ends, as it was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct End {
    /// Head of its last entry; zeros if it is empty.
    pub last: Head,
    /// The last starts in a row of which nothing is known from [`super::pace::SETTLED_S`] on.
    pub short_starts: u32,
}

/// The log was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the flash does not take an entry of the log")]
pub struct NotWritten;

/// A flash region with a log, for the time of an operation.
#[derive(Debug)]
pub struct EventLog<'f, F> {
    flash: &'f mut F,
    region: Range<u32>,
}

impl<'f, F: NorFlash> EventLog<'f, F> {
    /// The log in `region`, whole pages.
    pub const fn new(flash: &'f mut F, region: Range<u32>) -> Self {
        Self { flash, region }
    }

    /// Reads the log through, some milliseconds, and tells where it ends.
    #[inline(never)]
    pub fn end(&mut self) -> End {
        let mut end = End::default();
        self.each(&mut |bytes| {
            if let Some(head) = head(bytes) {
                end.note(&head);
            }
            true
        });
        end
    }

    /// Adds an entry and reads it back: 1 ms of flash, or 23 ms where a page is erased for it, and some milliseconds.
    ///
    /// # Errors
    /// [`NotWritten`].
    #[inline(never)]
    pub fn append(&mut self, head: &Head, event: &Event) -> Result<(), NotWritten> {
        let mut buffer = [0; ENTRY_BYTES];
        let bytes = encode(head, event, &mut buffer).ok_or(NotWritten)?;
        for _ in 0..ATTEMPTS {
            match self.push(bytes) {
                Ok(()) if self.end().last == *head => return Ok(()),
                // It lies where it is not found: marks that no log leaves.
                Ok(()) => self.erase(self.region.clone())?,
                Err(Some(place)) => self.erase(self.page_of(place))?,
                // The pages' marks contradict each other, as after two cuts: the oldest goes, and with it the contradiction.
                Err(None) => match self.oldest_page() {
                    Some(page) => self.erase(page)?,
                    None => self.erase(self.region.clone())?,
                },
            }
        }
        Err(NotWritten)
    }

    /// Entries behind the first `skip`, oldest first, as many as one reply carries.
    #[inline(never)]
    pub fn page(&mut self, skip: u16, page: &mut Page) {
        let (mut index, mut whole_bytes) = (0, 0);
        self.each(&mut |bytes| {
            whole_bytes += taken_bytes(bytes.len());
            if index >= skip && !page.more {
                page.more = !page.add(bytes);
            }
            index += 1;
            true
        });
        page.damaged_bytes = self.programmed_bytes().saturating_sub(whole_bytes);
    }

    /// Adds an entry's bytes; on an error the place that the flash did not take, none if the pages are not as they should be.
    fn push(&mut self, bytes: &[u8]) -> Result<(), Option<u32>> {
        flash_ring::push(self.flash, &self.region, bytes)
    }

    /// Gives whole entries to `take`, oldest first, until it says false. What is damaged is passed over.
    #[inline(never)]
    fn each(&mut self, take: &mut dyn FnMut(&[u8]) -> bool) {
        let mut buffer = [0; ENTRY_BYTES];
        flash_ring::each(self.flash, &self.region, &mut buffer, take);
    }

    /// The page whose entries are the oldest.
    #[inline(never)]
    fn oldest_page(&mut self) -> Option<Range<u32>> {
        let pages = self.region.clone().step_by(F::ERASE_SIZE);
        let ended = pages.filter_map(|start| {
            let page = start..start + F::ERASE_SIZE as u32;
            let last = EventLog::new(&mut *self.flash, page.clone())
                .end()
                .last
                .number;
            (last > 0).then_some((last, page.start))
        });
        let oldest = ended.min()?.1;
        Some(self.page_of(oldest))
    }

    fn page_of(&self, place: u32) -> Range<u32> {
        let start = place - place % F::ERASE_SIZE as u32;
        start..start + F::ERASE_SIZE as u32
    }

    fn erase(&mut self, place: Range<u32>) -> Result<(), NotWritten> {
        let erased = self.flash.erase(place.start, place.end);
        erased.map_err(|_| NotWritten)
    }

    /// Bytes that are not as an erase leaves them, the marks of pages aside.
    fn programmed_bytes(&mut self) -> u16 {
        let word_bytes = F::WRITE_SIZE as u32;
        let page_bytes = F::ERASE_SIZE as u32;
        let words = self.region.clone().step_by(F::WRITE_SIZE);
        let flash = &mut *self.flash;
        let is_programmed = |place: &u32| {
            let in_page = (place - self.region.start) % page_bytes;
            let is_mark = in_page == 0 || in_page == page_bytes - word_bytes;
            !is_mark && !is_erased(flash, *place)
        };
        (words.filter(is_programmed).count() * F::WRITE_SIZE) as u16
    }
}

fn is_erased<F: NorFlash>(flash: &mut F, place: u32) -> bool {
    let mut word = [0; 8];
    let word = &mut word[..F::WRITE_SIZE.min(8)];
    flash.read(place, word).is_ok() && word.iter().all(|byte| *byte == 0xFF)
}

impl End {
    /// Takes a further entry.
    fn note(&mut self, head: &Head) {
        // Pages whose order a cut has confused come in any order.
        if head.number < self.last.number {
            return;
        }
        let is_settled = head.time.uptime_s >= super::pace::SETTLED_S;
        if is_settled {
            self.short_starts = 0;
        } else if head.start != self.last.start {
            self.short_starts = self.short_starts.saturating_add(1);
        }
        self.last = *head;
    }
}
