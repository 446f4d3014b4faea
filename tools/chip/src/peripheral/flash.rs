//! The flash controller and both banks, which are `hal-sim`'s flash: double words that are written once, torn ones that cannot be read, a
//! supply that goes at any step.
//!
//! The *near* bank is the one that code runs from, bank 1 unless both have changed places. It is plain memory of the processor as well, and
//! whoever changes it breaks a rule. The other one is the *far* bank.

mod banks;

use super::{Access, Peripheral, Words};
use crate::bank::Bank;
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks, from_us};
use hal_sim::wire::flash::{FlashError, PAGE_BYTES, WORD_BYTES};
use stm32_metapac::flash::regs::{Acr, Cr, Optr, Sr};

/// The two keys, and option bytes as the factory sets them: two banks, no brown-out level (RM0440, 5.7).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// The option bytes' own keys (RM0440, 3.4.2).
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
const FACTORY_OPTIONS: u32 = 0xFFEF_F8AA;
/// Erasing a page and programming a double word (DS12288, flash characteristics, typical).
const ERASE: Ticks = from_us(22_000);
const PROGRAM: Ticks = from_us(82);
/// Flags of the status register that tell of an error.
const ERRORS: u32 = 0xC3FA;

const ACR: u32 = 0x00;
const SR: u32 = 0x10;
const CR: u32 = 0x14;
const ECCR: u32 = 0x18;
const OPTR: u32 = 0x20;

#[derive(Clone, Copy, Debug)]
enum Work {
    Erase {
        bank: usize,
        offset: u32,
    },
    Program {
        bank: usize,
        offset: u32,
        data: [u8; WORD_BYTES],
    },
    Options,
}

/// What the option bytes and the chip's past make of its start.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Option bytes.
    pub options: Optr,
    /// Error flags that are set from the beginning.
    pub errors: u32,
}

impl Default for Start {
    /// As docs/your-board.md wants the board: two banks, brown-out level 4, the pin BOOT0 does not count.
    fn default() -> Self {
        let mut options = Optr(FACTORY_OPTIONS);
        options.set_bor_lev(4);
        options.set_n_swboot0(false);
        Self { options, errors: 0 }
    }
}

/// Caches that may hold anything (`filled`), and that hold what was read before the banks changed places (`of_other`): first that of
/// instructions, then that of data.
#[derive(Clone, Copy, Debug)]
struct Stale {
    filled: [bool; 2],
    of_other: [bool; 2],
}

impl Stale {
    /// The caches are on, and the banks where they are.
    const AFTER_RESET: Self = Self {
        filled: [true; 2],
        of_other: [false; 2],
    };
}

/// The peripheral.
#[derive(Debug)]
pub struct Flash {
    words: Words,
    /// Bank 1 and bank 2.
    banks: [Bank; 2],
    swapped: bool,
    /// What prefetch, instruction cache and data cache hold may be the other bank's.
    stale: Stale,
    keys_seen: usize,
    locked_for_good: bool,
    option_keys_seen: usize,
    /// Option bytes as written into their register, and as programmed; they take effect at the next load.
    written_options: Option<u32>,
    programmed_options: Option<Optr>,
    launched: bool,
    half: Option<(u32, u32)>,
    work: Option<(Work, Ticks)>,
    /// The flash has changed since the data cache was reset.
    changed: bool,
    power_lost: bool,
    double_error: bool,
}

impl Flash {
    /// After reset (RM0440, 5.7): caches on, locked.
    pub fn after_reset(start: Start, banks: [Bank; 2]) -> Self {
        let reset = [
            (ACR, 0x0004_0600),
            (SR, start.errors & ERRORS),
            (CR, 0xC000_0000),
            (OPTR, start.options.0),
        ];
        Self {
            words: Words::after_reset(&reset),
            banks,
            swapped: false,
            stale: Stale::AFTER_RESET,
            keys_seen: 0,
            locked_for_good: false,
            option_keys_seen: 0,
            written_options: None,
            programmed_options: None,
            launched: false,
            half: None,
            work: None,
            changed: false,
            power_lost: false,
            double_error: false,
        }
    }

    /// Access control: wait states and caches.
    pub fn acr(&self) -> Acr {
        Acr(self.words.at(ACR))
    }

    /// Option bytes.
    pub fn options(&self) -> Optr {
        Optr(self.words.at(OPTR))
    }

    /// Option bytes that were programmed since the last reset: they are in force after the next load.
    pub fn programmed_options(&self) -> Option<Optr> {
        self.programmed_options
    }

    /// Whether the option bytes are to be loaded now, which resets the chip.
    pub fn launched(&self) -> bool {
        self.launched
    }

    /// Whether the supply went in the middle of an operation.
    pub fn power_lost(&self) -> bool {
        self.power_lost
    }

    /// True once for each double word whose check bits were found wrong: the cause of a non-maskable interrupt.
    pub fn take_double_error(&mut self) -> bool {
        std::mem::take(&mut self.double_error)
    }

    /// Operations of both banks so far, resets or not.
    pub fn operations(&self) -> u64 {
        self.banks.iter().map(Bank::operations).sum()
    }

    /// Until when the bank does not answer.
    pub fn busy_until(&self) -> Ticks {
        self.work.map_or(0, |(_, end)| end)
    }

    fn fail(&mut self, flag: u32, rule: Rule, detail: &str, access: &mut Access) {
        let errors = self.words.at(SR) | flag;
        self.words.put(SR, errors);
        access.broken(rule, detail);
    }

    /// Begins an operation, if nothing stands against it.
    fn begin(&mut self, work: Work, duration: Ticks, access: &mut Access) {
        if self.words.at(SR) & ERRORS != 0 {
            // PGSERR, bit 7: error flags of the past are still set.
            let detail = "an operation begins on error flags of the past";
            return self.fail(1 << 7, Rule::FlashSticky, detail, access);
        }
        let of_a_bank = !matches!(work, Work::Options);
        if of_a_bank && self.acr().dcen() {
            let detail =
                "an operation on one bank with the data cache on, while code reads the other";
            access.broken(Rule::FlashDataCache, detail);
        }
        if of_a_bank && !self.options().dbank() {
            access.broken(
                Rule::FlashSameBank,
                "an operation in single-bank mode, where the pages are others",
            );
        }
        self.changed |= of_a_bank;
        self.work = Some((work, access.now + duration));
    }

    fn finish(&mut self, work: Work, access: &mut Access) {
        let done = match work {
            Work::Erase { bank, offset } => self.banks[bank].erase(offset),
            Work::Program { bank, offset, data } => self.banks[bank].program(offset, data),
            Work::Options => {
                let written = self.written_options.unwrap_or(self.words.at(OPTR));
                self.programmed_options = Some(Optr(written));
                Ok(())
            }
        };
        match done {
            Ok(()) => {}
            Err(FlashError::Off) => self.power_lost = true,
            Err(FlashError::WrittenTwice) => {
                self.fail(
                    1 << 3,
                    Rule::FlashErased,
                    "a double word is programmed twice",
                    access,
                );
            }
            // OPERR, bit 1.
            Err(_) => {
                let errors = self.words.at(SR) | 1 << 1;
                self.words.put(SR, errors);
            }
        }
    }

    fn write_cr(&mut self, value: u32, access: &mut Access) {
        let (before, mut now) = (Cr(self.words.at(CR)), Cr(value));
        if before.lock() {
            return access.broken(Rule::FlashLocked, "FLASH.cr is written while it is locked");
        }
        if self.work.is_some() {
            return access.broken(
                Rule::FlashLocked,
                "FLASH.cr is written while the controller is busy",
            );
        }
        if now.mer1() || now.mer2() || now.fstpg() {
            access.broken(Rule::Unmodelled, format!("FLASH.cr: {value:#x}"));
        }
        if now.optstrt() || now.obl_launch() {
            self.write_option_control(before, now, access);
        }
        if now.strt() {
            if !now.per() {
                access.broken(
                    Rule::FlashLocked,
                    "FLASH.cr: a start without a kind of erase",
                );
            } else if usize::from(now.bker()) == self.near() {
                let detail = format!(
                    "page {} of bank {} is erased, from which code runs",
                    now.pnb(),
                    self.near() + 1
                );
                access.broken(Rule::FlashSameBank, detail);
            } else {
                let (bank, offset) = (self.far(), u32::from(now.pnb()) * PAGE_BYTES as u32);
                self.begin(Work::Erase { bank, offset }, ERASE, access);
            }
        }
        if now.lock() {
            self.keys_seen = 0;
            now.set_optlock(true);
        }
        if now.optlock() {
            self.option_keys_seen = 0;
        }
        now.set_obl_launch(false);
        now.set_strt(matches!(self.work, Some((Work::Erase { .. }, _))));
        now.set_optstrt(matches!(self.work, Some((Work::Options, _))));
        // Only the keys take it back.
        now.set_optlock(now.optlock() || before.optlock());
        self.half = None;
        self.words.put(CR, now.0);
    }

    /// Programming of the option bytes, and their load.
    fn write_option_control(&mut self, before: Cr, now: Cr, access: &mut Access) {
        if before.optlock() {
            let detail = "FLASH.cr: option bytes are started or launched while they are locked";
            return access.broken(Rule::OptionBytes, detail);
        }
        if now.optstrt() {
            self.begin(Work::Options, ERASE, access);
        }
        self.launched |= now.obl_launch();
    }

    fn write_option_key(&mut self, value: u32, access: &mut Access) {
        let mut cr = Cr(self.words.at(CR));
        if cr.lock() || !cr.optlock() || OPTION_KEYS.get(self.option_keys_seen) != Some(&value) {
            let detail = format!("FLASH.optkeyr: {value:#x}");
            return access.broken(Rule::OptionBytes, detail);
        }
        self.option_keys_seen += 1;
        if self.option_keys_seen == OPTION_KEYS.len() {
            cr.set_optlock(false);
            self.words.put(CR, cr.0);
        }
    }

    fn write_options(&mut self, value: u32, access: &mut Access) {
        if Cr(self.words.at(CR)).optlock() || self.work.is_some() {
            let detail = "FLASH.optr is written while it is locked, or the controller is busy";
            return access.broken(Rule::OptionBytes, detail);
        }
        self.written_options = Some(value);
    }

    fn write_key(&mut self, value: u32, access: &mut Access) {
        let mut cr = Cr(self.words.at(CR));
        if !cr.lock() || self.locked_for_good || KEYS.get(self.keys_seen) != Some(&value) {
            self.locked_for_good = true;
            return access.broken(Rule::FlashKey, format!("FLASH.keyr: {value:#x}"));
        }
        self.keys_seen += 1;
        if self.keys_seen == KEYS.len() {
            cr.set_lock(false);
            self.words.put(CR, cr.0);
        }
    }

    fn write_acr(&mut self, value: u32, access: &mut Access) {
        let (before, now) = (self.acr(), Acr(value));
        if now.dcrst() && now.dcen() {
            access.broken(
                Rule::FlashStaleCache,
                "the data cache is reset while it is on",
            );
        }
        if now.dcrst() && !now.dcen() {
            self.changed = false;
        }
        self.watch_caches(before, now, access);
        if now.dcen() && !before.dcen() && self.changed {
            let detail = "the data cache is on again after a change, and was not reset";
            access.broken(Rule::FlashStaleCache, detail);
        }
        self.words.put(ACR, now.0);
    }
}

impl Peripheral for Flash {
    fn peek(&self, register: &Register) -> u32 {
        let mut sr = Sr(self.words.at(SR));
        match register.name {
            "sr" => {
                sr.set_bsy(self.work.is_some());
                sr.0
            }
            "keyr" | "optkeyr" | "pdkeyr" => 0,
            "optr" => self.written_options.unwrap_or(self.words.at(OPTR)),
            _ => self.words.get(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "acr" => self.write_acr(value, access),
            "keyr" => self.write_key(value, access),
            "optkeyr" => self.write_option_key(value, access),
            "optr" => self.write_options(value, access),
            "sr" => {
                let flags = self.words.at(SR) & !value;
                self.words.put(SR, flags);
            }
            "cr" => self.write_cr(value, access),
            "eccr" => {
                // The flags of found errors, bits 28 to 31, go by writing ones; ECCIE is kept.
                let flags = self.words.at(ECCR) & 0xF000_0000 & !value;
                let place = self.words.at(ECCR) & 0x007F_FFFF;
                let place = if flags == 0 { 0 } else { place };
                self.words.put(ECCR, flags | value & 1 << 24 | place);
            }
            other => access.broken(Rule::Unmodelled, format!("FLASH.{other} is written")),
        }
    }

    fn next(&self) -> Ticks {
        self.work.map_or(NEVER, |(_, end)| end)
    }

    fn advance(&mut self, access: &mut Access) {
        if let Some((work, end)) = self.work
            && access.now >= end
        {
            self.work = None;
            let mut cr = Cr(self.words.at(CR));
            cr.set_strt(false);
            cr.set_optstrt(false);
            self.words.put(CR, cr.0);
            self.finish(work, access);
        }
    }
}
