//! Bank 2 of the flash, for the calibration's slots. Code runs from bank 1, so neither erase nor program stalls a fetch.
//!
//! A double word that lost power while it was programmed has wrong check bits: reading it raises the non-maskable
//! interrupt, which notes it ([`isr_ecc`]); the read then ends with an error, as a torn slot should.
#![allow(unsafe_code)] // the bank is memory

use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering::SeqCst};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use stm32_metapac::flash::regs::Sr;
use stm32_metapac::{FLASH, PWR};

const BASE: u32 = 0x0804_0000;
const BYTES: usize = 256 << 10;
const PAGE: u32 = 2048;
/// Looks at the busy bit: a page's erase takes 25 ms at most (data sheet), some ten million looks.
const PATIENCE: u32 = 50_000_000;

static TORN: AtomicBool = AtomicBool::new(false);

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
}

impl NorFlashError for Error {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The bank. There is one.
pub struct Flash(());

impl Flash {
    /// To be called once.
    pub fn take() -> Self {
        Self(())
    }
}

/// For the non-maskable interrupt: true if the flash's check bits were the cause, which is then taken back.
pub fn isr_ecc() -> bool {
    let cause = FLASH.eccr().read().eccd();
    if cause {
        FLASH.eccr().modify(|w| w.set_eccd(true));
        TORN.store(true, SeqCst);
    }
    cause
}

/// Unlocks the controller, runs `work`, locks it again.
fn unlocked(work: impl FnOnce() -> Result<(), Error>) -> Result<(), Error> {
    if PWR.sr2().read().pvdo() {
        return Err(Error::SupplyLow);
    }
    wait()?;
    if FLASH.cr().read().lock() {
        FLASH.keyr().write_value(0x4567_0123);
        FLASH.keyr().write_value(0xCDEF_89AB);
    }
    // Error flags of the past, each taken back by writing it.
    FLASH.sr().write_value(Sr(0xC3FA));
    let result = work();
    FLASH.cr().write(|w| w.set_lock(true));
    result
}

fn wait() -> Result<(), Error> {
    for _ in 0..PATIENCE {
        let status = FLASH.sr().read();
        if !status.bsy() {
            return if status.0 & 0xC3FA == 0 {
                Ok(())
            } else {
                Err(Error::Controller)
            };
        }
    }
    Err(Error::Controller)
}

impl ErrorType for Flash {
    type Error = Error;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        check_read(self, offset, bytes.len()).map_err(Error::Arguments)?;
        TORN.store(false, SeqCst);
        for (place, address) in bytes.iter_mut().zip(BASE + offset..) {
            // SAFETY: within the bank, checked above.
            *place = unsafe { read_volatile(address as *const u8) };
        }
        if TORN.load(SeqCst) {
            Err(Error::Torn)
        } else {
            Ok(())
        }
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        check_erase(self, from, to).map_err(Error::Arguments)?;
        for page in from / PAGE..to / PAGE {
            unlocked(|| {
                FLASH.cr().write(|w| {
                    w.set_per(true);
                    w.set_bker(true);
                    w.set_pnb(page as u8);
                });
                FLASH.cr().modify(|w| w.set_strt(true));
                wait()
            })?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        check_write(self, offset, bytes.len()).map_err(Error::Arguments)?;
        unlocked(|| {
            FLASH.cr().write(|w| w.set_pg(true));
            for (words, address) in bytes
                .as_chunks::<8>()
                .0
                .iter()
                .zip((BASE + offset..).step_by(8))
            {
                let [a, b, c, d, e, f, g, h] = *words;
                // SAFETY: a double word within the bank, checked above; the controller is unlocked and waits for it.
                unsafe {
                    write_volatile(address as *mut u32, u32::from_le_bytes([a, b, c, d]));
                    write_volatile((address + 4) as *mut u32, u32::from_le_bytes([e, f, g, h]));
                }
                wait()?;
            }
            Ok(())
        })
    }
}
