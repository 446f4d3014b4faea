//! What lies where in a bank of flash. Both banks are laid out alike, and whichever is started lies at the same address.
//!
//! ```text
//! 0x00000 | first stage (bank 1; free in bank 2)                       8 KiB |
//! 0x02000 | header 512 B | vectors, code, constants                  216 KiB |
//! 0x38000 | tooth maps                                                16 KiB |
//! 0x3C000 | calibration slots                                          4 KiB |
//! 0x3D000 | journal                                                    2 KiB |
//! 0x3D800 | log                                                        8 KiB |
//! 0x3F800 | free                                                       2 KiB |
//! ```
//! An image uses the maps, the slots, the journal and the log of the *other* bank: it never writes the bank that it runs from, so that no write stalls a
//! fetch of the sampling interrupt.

use crate::calibration::slots::{SLOT_BYTES, SLOTS};
use crate::maps;

/// Bytes of a bank of the STM32G474RE.
pub const BANK_BYTES: u32 = 256 << 10;
/// Bytes of a page, the least that is erased.
pub const PAGE_BYTES: u32 = 2048;
/// Bytes of a double word, the least that is programmed.
pub const WORD_BYTES: u32 = 8;

/// Where the image begins, with its header; the first stage has the pages before.
pub const IMAGE_START: u32 = 0x2000;
/// Room for the header. The vectors follow: the processor wants the STM32G474's 118 of them at a multiple of 512 bytes.
pub const HEADER_ROOM: u32 = 512;
/// Where the body begins.
pub const BODY_START: u32 = IMAGE_START + HEADER_ROOM;
/// Where the number under which an image was installed stands: the last double word of the header's room.
pub const NUMBER_START: u32 = BODY_START - WORD_BYTES;
/// End of the image: the last 32 KiB of a bank hold no code.
pub const IMAGE_END: u32 = 0x3_8000;
/// Longest body, bytes.
pub const MOST_BODY_BYTES: u32 = IMAGE_END - BODY_START;

/// Where the tooth maps lie.
pub const MAPS_START: u32 = IMAGE_END;
/// Their end.
pub const MAPS_END: u32 = MAPS_START + maps::SLOTS as u32 * maps::SLOT_BYTES;
/// Where the calibration slots lie: as before there were maps.
pub const SLOTS_START: u32 = 0x3_C000;
/// Their end.
pub const SLOTS_END: u32 = SLOTS_START + (SLOTS * SLOT_BYTES) as u32;
/// The journal's page.
pub const JOURNAL_START: u32 = SLOTS_END;
/// Its end.
pub const JOURNAL_END: u32 = JOURNAL_START + PAGE_BYTES;

/// Where the log of the board's story lies.
pub const LOG_START: u32 = JOURNAL_END;
/// Its end: four pages.
pub const LOG_END: u32 = LOG_START + 4 * PAGE_BYTES;

const _: () = assert!(
    MAPS_END <= SLOTS_START
        && LOG_END <= BANK_BYTES
        && IMAGE_START.is_multiple_of(PAGE_BYTES)
        && IMAGE_END.is_multiple_of(PAGE_BYTES)
        && BODY_START.is_multiple_of(512),
    "the parts are whole pages and lie within the bank"
);
