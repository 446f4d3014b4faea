//! The flash controller's registers and both banks' memory. What is done with them is [`crate::drivers::g4_flash`]'s.
//!
//! The bank that code runs from lies at [`NEAR`], whichever it is: the first stage makes the banks change places for that. Wrong check bits
//! raise the non-maskable interrupt, which notes those of what is read as data ([`isr_ecc`]).
#![allow(unsafe_code)] // the banks are memory

use crate::drivers::g4_flash::{Bank, BankNumber, Controller, is_laid_out, is_torn};
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering::SeqCst};
use stm32_metapac::flash::regs::{Acr, Cr, Sr};
use stm32_metapac::{FLASH, PWR, SYSCFG};

/// First byte of the bank that code runs from, and of the other one.
const NEAR: u32 = 0x0800_0000;
const FAR: u32 = 0x0804_0000;

/// The bank that somebody reads as data, 1 or 2, or 0: wrong check bits are expected there, and nowhere else.
static READING: AtomicU8 = AtomicU8::new(0);
static TORN: AtomicBool = AtomicBool::new(false);

/// A bank.
pub type Flash = Bank<Registers>;

/// The controller, and one of the banks.
pub struct Registers {
    base: u32,
    number: BankNumber,
}

/// The option bytes' register.
pub fn options() -> u32 {
    FLASH.optr().read().0
}

/// Gives out the bank that code runs from, to be read, and the other one; says so in the log if nothing can be stored there. To be called
/// once, when the system configuration has its clock.
pub fn take() -> (Flash, Flash) {
    let options = options();
    if !is_laid_out(options) {
        defmt::error!(
            "option bytes {=u32:#x}: nothing will be stored, wanted DBANK=1 BFB2=0",
            options
        );
    }
    let runs = match SYSCFG.memrmp().read().fb_mode() {
        false => BankNumber::One,
        true => BankNumber::Two,
    };
    let registers = |base, number| Registers { base, number };
    (
        Bank::running(registers(NEAR, runs)),
        Bank::new(registers(FAR, runs.other())),
    )
}

/// For the non-maskable interrupt: true if a torn double word was the cause, which is noted and taken back.
pub fn isr_ecc() -> bool {
    let reading = match READING.load(SeqCst) {
        1 => Some(BankNumber::One),
        2 => Some(BankNumber::Two),
        _ => None,
    };
    let torn = is_torn(FLASH.eccr().read().0, reading);
    if torn {
        FLASH.eccr().modify(|w| w.set_eccd(true));
        TORN.store(true, SeqCst);
    }
    torn
}

impl Controller for Registers {
    fn number(&mut self) -> BankNumber {
        self.number
    }

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
        let address = self.base + offset;
        // SAFETY: a double word within the bank, as the bank has checked; the controller is unlocked and waits for it.
        unsafe {
            write_volatile(address as *mut u32, low);
            write_volatile((address + 4) as *mut u32, high);
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        TORN.store(false, SeqCst);
        let number = match self.number {
            BankNumber::One => 1,
            BankNumber::Two => 2,
        };
        READING.store(number, SeqCst);
        for (place, address) in bytes.iter_mut().zip(self.base + offset..) {
            // SAFETY: within the bank, as the bank has checked.
            *place = unsafe { read_volatile(address as *const u8) };
        }
        // The last read has ended, and its interrupt has come, before anybody looks.
        cortex_m::asm::dsb();
        READING.store(0, SeqCst);
        TORN.load(SeqCst)
    }
}
