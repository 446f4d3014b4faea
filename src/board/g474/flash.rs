//! The flash controller's registers and bank 2's memory, for the calibration's slots. What is done with them is
//! [`crate::drivers::g4_flash`]'s.
//!
//! Wrong check bits raise the non-maskable interrupt, which notes those of a slot that is read ([`isr_ecc`]).
#![allow(unsafe_code)] // the bank is memory

use crate::drivers::g4_flash::{Bank, Controller, is_laid_out, is_torn_slot};
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering::SeqCst};
use stm32_metapac::flash::regs::{Acr, Cr, Sr};
use stm32_metapac::{FLASH, PWR};

/// Bank 2's first byte.
const BASE: u32 = 0x0804_0000;

/// Somebody reads the bank: wrong check bits are expected there, and nowhere else.
static READING: AtomicBool = AtomicBool::new(false);
static TORN: AtomicBool = AtomicBool::new(false);

/// Bank 2.
pub type Flash = Bank<Registers>;

/// The controller. There is one.
pub struct Registers(());

/// The option bytes' register.
pub fn options() -> u32 {
    FLASH.optr().read().0
}

/// Gives out the bank; says so in the log if nothing can be stored there. To be called once.
pub fn take() -> Flash {
    let options = options();
    if !is_laid_out(options) {
        defmt::error!(
            "option bytes {=u32:#x}: nothing will be stored, wanted DBANK=1 BFB2=0",
            options
        );
    }
    Bank::new(Registers(()))
}

/// For the non-maskable interrupt: true if a torn slot was the cause, which is noted and taken back.
pub fn isr_ecc() -> bool {
    let torn = is_torn_slot(FLASH.eccr().read().0, READING.load(SeqCst));
    if torn {
        FLASH.eccr().modify(|w| w.set_eccd(true));
        TORN.store(true, SeqCst);
    }
    torn
}

impl Controller for Registers {
    fn status(&mut self) -> u32 {
        FLASH.sr().read().0
    }

    fn clear_status(&mut self, flags: u32) {
        FLASH.sr().write_value(Sr(flags));
    }

    fn control(&mut self) -> u32 {
        FLASH.cr().read().0
    }

    fn set_control(&mut self, bits: u32) {
        FLASH.cr().write_value(Cr(bits));
    }

    fn access(&mut self) -> u32 {
        FLASH.acr().read().0
    }

    fn set_access(&mut self, bits: u32) {
        FLASH.acr().write_value(Acr(bits));
    }

    fn options(&mut self) -> u32 {
        FLASH.optr().read().0
    }

    fn key(&mut self, key: u32) {
        FLASH.keyr().write_value(key);
    }

    fn supply_is_low(&mut self) -> bool {
        PWR.sr2().read().pvdo()
    }

    fn program(&mut self, offset: u32, [low, high]: [u32; 2]) {
        let address = BASE + offset;
        // SAFETY: a double word within the bank, as the bank has checked; the controller is unlocked and waits for it.
        unsafe {
            write_volatile(address as *mut u32, low);
            write_volatile((address + 4) as *mut u32, high);
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        TORN.store(false, SeqCst);
        READING.store(true, SeqCst);
        for (place, address) in bytes.iter_mut().zip(BASE + offset..) {
            // SAFETY: within the bank, as the bank has checked.
            *place = unsafe { read_volatile(address as *const u8) };
        }
        // The last read has ended, and its interrupt has come, before anybody looks.
        cortex_m::asm::dsb();
        READING.store(false, SeqCst);
        TORN.load(SeqCst)
    }
}
