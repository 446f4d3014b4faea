//! The two banks of the STM32G4's flash, each as NOR flash of embedded-storage. Only the one that no code runs from is written, so that
//! neither erase nor program stalls a fetch.
//!
//! The banks may have changed places in the memory map. An offset in a bank is the same wherever that lies, but the controller counts pages
//! and wrong check bits by the bank that they are really in ([`Controller::number`]).
//!
//! The order of steps alone: registers and memory are behind [`Controller`], which the board has and a test imitates. A double word that
//! lost power while it was programmed has wrong check bits: reading it ends with an error, as a torn slot should.
//!
//! Sources: RM0440, chapter 5 (bits, keys, order of steps); data sheet DS12288 (times).

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// Bytes of the bank.
pub const BYTES: usize = 256 << 10;
/// Bytes of a page, the least that is erased.
pub const PAGE_BYTES: u32 = 2048;
/// Both keys that unlock the control register, in their order.
pub const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Bits of the status register (SR).
pub mod status {
    /// All error flags; each is taken back by writing it.
    pub const ERRORS: u32 = 0xC3FA;
    /// An operation is under way, in either bank.
    pub const BUSY: u32 = 1 << 16;
}

/// Bits of the control register (CR).
pub mod control {
    /// Programming.
    pub const PROGRAM: u32 = 1 << 0;
    /// Erasing of a page.
    pub const ERASE_PAGE: u32 = 1 << 1;
    /// Place of the page's number.
    pub const PAGE_SHIFT: u32 = 3;
    /// The page is one of bank 2.
    pub const BANK_2: u32 = 1 << 11;
    /// Starts the erase.
    pub const START: u32 = 1 << 16;
    /// The register is locked.
    pub const LOCK: u32 = 1 << 31;
}

/// Bits of the access control register (ACR).
pub mod access {
    /// The data cache is on.
    pub const DATA_CACHE: u32 = 1 << 10;
    /// Empties the data cache; only while it is off.
    pub const DATA_CACHE_RESET: u32 = 1 << 12;
}

/// Bits of the check bits' register (ECCR).
pub mod check_bits {
    /// The double word lies in bank 2.
    pub const BANK_2: u32 = 1 << 21;
    /// It lies in the system memory.
    pub const SYSTEM_MEMORY: u32 = 1 << 22;
    /// Two bits or more of a double word were wrong; taken back by writing it.
    pub const UNCORRECTED: u32 = 1 << 31;
}

/// Bits of the option bytes' register (OPTR).
pub mod options {
    /// Start from bank 2, which then is where bank 1 was.
    pub const BOOT_BANK_2: u32 = 1 << 20;
    /// Two banks. Without it pages are 4 KiB and counted from the flash's start: erasing "page 0" would take the vectors.
    pub const DUAL_BANK: u32 = 1 << 22;
    /// nSWBOOT0: the pin BOOT0 decides whether the chip's built-in loader starts instead of the firmware; without it nBOOT0 does.
    pub const BOOT0_BY_PIN: u32 = 1 << 26;
    /// nBOOT0: the firmware starts.
    pub const BOOT0_VALUE: u32 = 1 << 27;
    /// Place of the brown-out level, three bits (BOR_LEV).
    pub const BROWN_OUT_SHIFT: u32 = 8;
    /// The highest: 2.8 V (data sheet DS12288), as the converters' supply needs it.
    pub const BROWN_OUT_LEVEL: u8 = 4;
}

/// Whether the option bytes (`options`, the register's bits) lay the flash out as this file takes it.
pub const fn is_laid_out(options: u32) -> bool {
    options & (options::DUAL_BANK | options::BOOT_BANK_2) == options::DUAL_BANK
}

/// Whether wrong check bits (`ecc`, the register's bits) are those of a double word that was torn when it was written: in the bank that
/// somebody reads as data. Anywhere else they are code or constants that are no longer what was flashed, and nothing may go on with these.
pub const fn is_torn(ecc: u32, reading: Option<BankNumber>) -> bool {
    let place = ecc & (check_bits::UNCORRECTED | check_bits::BANK_2 | check_bits::SYSTEM_MEMORY);
    match reading {
        None => false,
        Some(BankNumber::One) => place == check_bits::UNCORRECTED,
        Some(BankNumber::Two) => place == check_bits::UNCORRECTED | check_bits::BANK_2,
    }
}

/// A bank, by the number that the controller knows it by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BankNumber {
    /// The lower, unless both have changed places.
    One,
    /// The other.
    Two,
}

impl BankNumber {
    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::One => Self::Two,
            Self::Two => Self::One,
        }
    }
}

/// Looks at the busy bit: a page's erase takes 25 ms at most (data sheet), some ten million looks.
const PATIENCE: u32 = 50_000_000;

/// The controller's registers and a bank's memory.
pub trait Controller {
    /// Which bank it is.
    fn number(&mut self) -> BankNumber;
    /// The status register.
    fn status(&mut self) -> u32;
    /// Takes back flags of the status register.
    fn clear_status(&mut self, flags: u32);
    /// The control register.
    fn control(&mut self) -> u32;
    /// Writes the control register.
    fn set_control(&mut self, bits: u32);
    /// The access control register.
    fn access(&mut self) -> u32;
    /// Writes the access control register.
    fn set_access(&mut self, bits: u32);
    /// The option bytes' register.
    fn options(&mut self) -> u32;
    /// Writes the key register.
    fn key(&mut self, key: u32);
    /// Whether the supply is too low to write.
    fn supply_is_low(&mut self) -> bool;
    /// Programs the double word at an offset of the bank, the lower word first.
    fn program(&mut self, offset: u32, words: [u32; 2]);
    /// Reads from an offset of the bank; true if a double word's check bits were wrong.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool;
}

/// What can go wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Out of bounds or not aligned.
    Arguments(NorFlashErrorKind),
    /// A double word whose check bits are wrong.
    Torn,
    /// The controller said so, or did not end.
    Controller,
    /// The supply is too low to write.
    SupplyLow,
    /// By the option bytes there are no two banks, or the chip's own loader has changed their places ([`is_laid_out`]).
    Layout,
    /// It is the bank that code runs from.
    Running,
}

impl NorFlashError for Error {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// A bank.
#[derive(Debug)]
pub struct Bank<C> {
    controller: C,
    runs: bool,
}

impl<C: Controller> Bank<C> {
    /// A bank that no code runs from. Nothing is written yet.
    pub const fn new(controller: C) -> Self {
        let runs = false;
        Self { controller, runs }
    }

    /// The bank that code runs from: to be read alone.
    pub const fn running(controller: C) -> Self {
        let runs = true;
        Self { controller, runs }
    }

    /// Its registers.
    pub fn controller(&mut self) -> &mut C {
        &mut self.controller
    }

    /// Unlocks the controller, runs `work`, locks it again.
    fn unlocked(&mut self, work: impl FnOnce(&mut Self) -> Result<(), Error>) -> Result<(), Error> {
        if self.runs {
            return Err(Error::Running);
        }
        if !is_laid_out(self.controller.options()) {
            return Err(Error::Layout);
        }
        if self.controller.supply_is_low() {
            return Err(Error::SupplyLow);
        }
        self.wait()?;
        if self.controller.control() & control::LOCK != 0 {
            KEYS.iter().for_each(|key| self.controller.key(*key));
        }
        // Error flags stay until they are taken back, and any of them refuses the next operation.
        self.controller.clear_status(status::ERRORS);
        let result = self.without_data_cache(work);
        self.controller.clear_status(status::ERRORS);
        self.controller.set_control(control::LOCK);
        result
    }

    /// Does `work` with the data cache off, and empties it before it is on again. While one bank is written a read of the other may
    /// leave wrong data in the cache (erratum ES0430 2.2.2), and what it holds of the bank that is written is out of date.
    fn without_data_cache(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let access = self.controller.access();
        let off = access & !access::DATA_CACHE;
        self.controller.set_access(off);
        let result = work(self);
        self.controller.set_access(off | access::DATA_CACHE_RESET);
        self.controller.set_access(off);
        self.controller.set_access(access);
        result
    }

    /// Waits until no operation is under way; what the flags say then is of the operations before.
    fn wait(&mut self) -> Result<u32, Error> {
        (0..PATIENCE)
            .map(|_| self.controller.status())
            .find(|status| status & status::BUSY == 0)
            .ok_or(Error::Controller)
    }

    /// Waits for the operation that was begun, and tells whether it succeeded.
    fn finish(&mut self) -> Result<(), Error> {
        match self.wait()? & status::ERRORS {
            0 => Ok(()),
            _ => Err(Error::Controller),
        }
    }

    fn erase_page(&mut self, page: u32) -> Result<(), Error> {
        let bank = match self.controller.number() {
            BankNumber::One => 0,
            BankNumber::Two => control::BANK_2,
        };
        let page = control::ERASE_PAGE | bank | page << control::PAGE_SHIFT;
        self.controller.set_control(page);
        self.controller.set_control(page | control::START);
        self.finish()
    }

    fn program(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.controller.set_control(control::PROGRAM);
        let double_words = bytes.as_chunks::<8>().0.iter();
        for (bytes, offset) in double_words.zip((offset..).step_by(8)) {
            let [a, b, c, d, e, f, g, h] = *bytes;
            let words = [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes);
            self.controller.program(offset, words);
            self.finish()?;
        }
        Ok(())
    }
}

impl<C> ErrorType for Bank<C> {
    type Error = Error;
}

impl<C: Controller> ReadNorFlash for Bank<C> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        check_read(self, offset, bytes.len()).map_err(Error::Arguments)?;
        if self.controller.read(offset, bytes) {
            Err(Error::Torn)
        } else {
            Ok(())
        }
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl<C: Controller> NorFlash for Bank<C> {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        check_erase(self, from, to).map_err(Error::Arguments)?;
        (from / PAGE_BYTES..to / PAGE_BYTES)
            .try_for_each(|page| self.unlocked(|bank| bank.erase_page(page)))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        check_write(self, offset, bytes.len()).map_err(Error::Arguments)?;
        self.unlocked(|bank| bank.program(offset, bytes))
    }
}
