//! A ring of entries in a NOR flash, by sequential-storage's queue.
//!
//! The library is generic over the flash, so that it is compiled where the flash is known, with that package's settings and once for each. Here it
//! is compiled once, for a flash behind a pointer: 1 KB less of the image. Nothing of a flash ever waits, so each operation ends at the first
//! poll.
#![no_std]

mod blocking;
mod flash;

pub use flash::{Flash, PAGE_BYTES, WORD_BYTES};

use blocking::{Blocking, now};
use core::ops::Range;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::queue::{QueueConfig, QueueStorage};

type Queue<'f> = QueueStorage<Blocking<'f>, Cache<Uncached, Uncached, Uncached, ()>>;

/// Adds an entry; the oldest page goes if there is no room.
///
/// # Errors
/// The place that the flash did not take, none if the pages are not as they should be.
#[inline(never)]
pub fn push(flash: &mut dyn Flash, region: &Range<u32>, bytes: &[u8]) -> Result<(), Option<u32>> {
    let mut failed_at = None;
    let mut queue = queue(flash, region, &mut failed_at).ok_or(None)?;
    match now(queue.push(bytes, true)) {
        Some(Ok(())) => Ok(()),
        _ => Err(failed_at),
    }
}

/// Gives whole entries to `take`, oldest first, until it says false. What is damaged is passed over. `buffer`: room for the longest entry, and for
/// what fills its last double word.
#[inline(never)]
pub fn each(
    flash: &mut dyn Flash,
    region: &Range<u32>,
    buffer: &mut [u8],
    take: &mut dyn FnMut(&[u8]) -> bool,
) {
    let mut failed_at = None;
    let Some(mut queue) = queue(flash, region, &mut failed_at) else {
        return;
    };
    let walk = async {
        let mut entries = queue.iter().await.ok()?;
        while let Some(entry) = entries.next(buffer).await.ok()? {
            if !take(&entry) {
                break;
            }
        }
        Some(())
    };
    // A ring that cannot be read further ends there.
    let _ = now(walk);
}

/// What an entry of so many bytes takes in flash.
#[must_use]
pub fn taken_bytes(bytes: usize) -> u16 {
    let head = Queue::item_overhead_size() as usize;
    (head + bytes.next_multiple_of(WORD_BYTES)) as u16
}

fn queue<'f>(
    flash: &'f mut dyn Flash,
    region: &Range<u32>,
    failed_at: &'f mut Option<u32>,
) -> Option<Queue<'f>> {
    let config = QueueConfig::try_new(region.clone()).ok()?;
    Some(QueueStorage::new(
        Blocking::new(flash, failed_at),
        config,
        Cache::new_uncached(),
    ))
}
