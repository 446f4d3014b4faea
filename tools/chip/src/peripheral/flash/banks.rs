//! Both banks: which is where, what is read and stored, and what caches still hold after they have changed places.

use super::{CR, ECCR, Flash, PROGRAM, Work};
use crate::bank::Bank;
use crate::peripheral::Access;
use crate::rule::Rule;
use crate::time::to_ns;
use hal_sim::wire::flash::WORD_BYTES;
use stm32_metapac::flash::regs::{Acr, Cr, Eccr};

impl Flash {
    /// Whether the banks have changed places.
    pub fn swapped(&self) -> bool {
        self.swapped
    }

    /// Index of the bank that code runs from.
    pub fn near(&self) -> usize {
        usize::from(self.swapped)
    }

    pub(super) fn far(&self) -> usize {
        1 - self.near()
    }

    /// The bank that code runs from.
    pub fn near_bank(&self) -> &Bank {
        &self.banks[self.near()]
    }

    /// The banks change places. What caches hold would be the other bank's.
    pub fn swap(&mut self, access: &mut Access) {
        self.swapped = !self.swapped;
        let acr = self.acr();
        let on = [acr.icen(), acr.dcen()];
        if on != [false; 2] || acr.prften() {
            let detail = "the banks change places with prefetch or a cache on";
            access.broken(Rule::BankSwap, detail);
        }
        if self.work.is_some() {
            let detail = "the banks change places while the controller is busy";
            access.broken(Rule::BankSwap, detail);
        }
        for (of_other, filled) in self.stale.of_other.iter_mut().zip(self.stale.filled) {
            *of_other |= filled;
        }
    }

    /// The check bits of a double word of a bank are found wrong while it is read.
    pub fn note_double_error(&mut self, bank: usize, offset: u32) {
        let mut eccr = Eccr(self.words.at(ECCR));
        eccr.set_eccd(true);
        eccr.set_bk_ecc(bank == 1);
        eccr.set_addr_ecc(offset / WORD_BYTES as u32);
        self.words.put(ECCR, eccr.0);
        self.double_error = true;
    }

    /// The far bank is about to be read: if it is erased or programmed, the processor stands still until that ends.
    pub fn note_read_while_written(&mut self, access: &mut Access) {
        if let Some((Work::Erase { .. } | Work::Program { .. }, end)) = self.work {
            let detail = format!(
                "the bank that is written is read: the processor stands still for {} us",
                to_ns(end.saturating_sub(access.now)) / 1000
            );
            access.broken(Rule::FlashReadWhileWrite, detail);
        }
    }

    /// Reads the far bank; a torn double word reads as it is and is noted.
    pub fn read_far(&mut self, offset: u32, bytes: &mut [u8]) {
        let far = self.far();
        if self.banks[far].read(offset, bytes) {
            self.note_double_error(far, offset);
        }
    }

    /// A store into the far bank.
    pub fn write_far(&mut self, offset: u32, value: u32, width: usize, access: &mut Access) {
        let cr = Cr(self.words.at(CR));
        if self.work.is_some() {
            return self.fail(
                1 << 7,
                Rule::FlashLocked,
                "a store while the controller is busy",
                access,
            );
        }
        if !cr.pg() {
            return self.fail(1 << 7, Rule::FlashDoubleWord, "a store without PG", access);
        }
        if width != 4 || offset % 4 != 0 {
            return self.fail(
                1 << 6,
                Rule::FlashDoubleWord,
                "a store of less than a word",
                access,
            );
        }
        match self.half.take() {
            None if offset % 8 == 0 => self.half = Some((offset, value)),
            Some((first, low)) if offset == first + 4 => {
                let mut data = [0; WORD_BYTES];
                data[..4].copy_from_slice(&low.to_le_bytes());
                data[4..].copy_from_slice(&value.to_le_bytes());
                self.begin(
                    Work::Program {
                        bank: self.far(),
                        offset: first,
                        data,
                    },
                    PROGRAM,
                    access,
                );
            }
            _ => self.fail(
                1 << 5,
                Rule::FlashDoubleWord,
                "words that are not one double word",
                access,
            ),
        }
    }

    /// A cache that holds lines of the bank that was here before must be emptied before it is on again.
    pub(super) fn watch_caches(&mut self, before: Acr, now: Acr, access: &mut Access) {
        let (was_on, on) = ([before.icen(), before.dcen()], [now.icen(), now.dcen()]);
        let emptied = [now.icrst(), now.dcrst()];
        for (cache, name) in ["instruction", "data"].into_iter().enumerate() {
            if emptied[cache] && !on[cache] {
                self.stale.filled[cache] = false;
                self.stale.of_other[cache] = false;
            }
            if on[cache] && !was_on[cache] && self.stale.of_other[cache] {
                let detail =
                    format!("the {name} cache is on again and holds lines of the other bank");
                access.broken(Rule::FlashStaleCache, detail);
            }
            self.stale.filled[cache] |= on[cache];
        }
    }
}
