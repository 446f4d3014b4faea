//! Answers that the host has given ahead: see [`crate::emulation::AHEAD_BASE`]. Used by the sampling interrupt, and by
//! start-up before it.
#![allow(unsafe_code)] // memory that the host shares

use crate::emulation::{
    AHEAD_BASE, AHEAD_BYTES, AHEAD_INSTANTS, AheadWord, ahead_instant, ahead_question,
};
use core::ptr::{read_volatile, write_volatile};

fn word(word: AheadWord) -> *mut u32 {
    (AHEAD_BASE + 4 * word as u32) as *mut u32
}

/// Takes the answer to the conversion of this instant, if there is one; what was meant for earlier instants goes by.
pub fn take_conversion(now: u32, period: u32) -> Option<u32> {
    // SAFETY: words that the host writes only while this processor stands still; the index is bounded.
    unsafe {
        let given = read_volatile(word(AheadWord::Given)).min(AHEAD_INSTANTS);
        let mut taken = read_volatile(word(AheadWord::Taken));
        while taken < given {
            let place = ahead_instant(taken) as *const u32;
            taken += 1;
            write_volatile(word(AheadWord::Taken), taken);
            let late = now
                .wrapping_sub(read_volatile(place))
                .wrapping_add(period / 2);
            if late < period {
                write_volatile(word(AheadWord::Chips), 0);
                return Some(read_volatile(place.add(1)));
            }
        }
        None
    }
}

/// Takes the answer to a chip's transfer at the instant taken last, into the place of the question; false: there is none,
/// or something else was asked.
#[inline(always)]
pub fn take_transfer(chip: u32, words: &mut [u8]) -> bool {
    let asked = ahead_question(chip);
    // SAFETY: as above; the lengths are bounded by the place's.
    unsafe {
        let taken = read_volatile(word(AheadWord::Taken));
        let chips = read_volatile(word(AheadWord::Chips));
        let known = read_volatile(asked as *const u32);
        let fits = known as usize == words.len() && (1..=AHEAD_BYTES).contains(&known);
        if chip > 1 || !(1..=AHEAD_INSTANTS).contains(&taken) || chips >> chip & 1 != 0 || !fits {
            return false;
        }
        let bytes = |place: u32| core::slice::from_raw_parts(place as *const u8, words.len());
        if *words != *bytes(asked + 4) {
            return false;
        }
        words.copy_from_slice(bytes(ahead_instant(taken - 1) + 8 + chip * AHEAD_BYTES));
        write_volatile(word(AheadWord::Chips), chips | 1 << chip);
    }
    true
}
