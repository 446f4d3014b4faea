//! What a debug probe erases besides the places that it writes an image to.
//!
//! An image that an update has put into bank 2 would be taken for a newer one than what the probe writes into bank 1: its header goes. The
//! journal in bank 1, which tells of that image, goes with it. The calibrations are left alone: the image finds them in either bank.

use courier_sensor::update::layout::{BANK_BYTES, IMAGE_START, JOURNAL_START, PAGE_BYTES};
use std::ops::Range;

/// Where bank 1 begins after a reset (RM0440, memory map).
const FLASH: u32 = 0x0800_0000;

/// Addresses of the pages to be erased: bank 1's journal, bank 2's header.
pub const OUTDATED: [Range<u32>; 2] = [
    page(FLASH + JOURNAL_START),
    page(FLASH + BANK_BYTES + IMAGE_START),
];

const fn page(start: u32) -> Range<u32> {
    start..start + PAGE_BYTES
}
