//! A part of the log on its way to a host: entries as they lie in flash, which the host reads.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Bytes of entries that one reply carries.
pub const PAGE_BYTES: usize = 384;

/// A part of the log, on its way to a host: each entry behind one byte with its length.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Page {
    /// The entries.
    pub bytes: Vec<u8, PAGE_BYTES>,
    /// Whether others follow.
    pub more: bool,
    /// Bytes in the log that belong to no whole entry: what was cut short or decayed, and is skipped.
    pub damaged_bytes: u16,
}

impl Page {
    /// The entries that it holds.
    pub fn entries(&self) -> impl Iterator<Item = &[u8]> {
        let mut rest = &self.bytes[..];
        core::iter::from_fn(move || {
            let (length, behind) = rest.split_first()?;
            let (entry, behind) = behind.split_at_checked(usize::from(*length))?;
            rest = behind;
            Some(entry)
        })
    }

    /// Adds one, of 255 bytes at most; false if there is no room.
    pub fn add(&mut self, entry: &[u8]) -> bool {
        let fits = self.bytes.len() + 1 + entry.len() <= PAGE_BYTES;
        if fits {
            // There is room for both.
            let _ = self.bytes.push(entry.len() as u8);
            let _ = self.bytes.extend_from_slice(entry);
        }
        fits
    }
}
