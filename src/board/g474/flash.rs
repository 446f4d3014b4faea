//! Both banks' memory. What is done with it is [`crate::drivers::g4_flash`]'s.
//!
//! The bank that code runs from lies at [`NEAR`], whichever it is: the first stage makes the banks change places for that. Wrong check bits
//! raise the non-maskable interrupt, which notes those of what is read as data ([`isr_ecc`]).
#![allow(unsafe_code)] // the banks are memory

pub use crate::board::flash_controller::options;

use crate::board::flash_controller::{Memory, Registers};
use crate::drivers::g4_flash::{Bank, BankNumber, is_laid_out, is_torn};
use core::ptr::read_volatile;
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering::SeqCst};
use stm32_metapac::{FLASH, PWR, SYSCFG};

/// First byte of the bank that code runs from, and of the other one.
const NEAR: u32 = 0x0800_0000;
const FAR: u32 = 0x0804_0000;

/// The bank that somebody reads as data, 1 or 2, or 0: wrong check bits are expected there, and nowhere else.
static READING: AtomicU8 = AtomicU8::new(0);
static TORN: AtomicBool = AtomicBool::new(false);

/// A bank.
pub type Flash = Bank<Registers<Place>>;

/// Where one of the banks lies.
pub struct Place {
    base: u32,
    number: BankNumber,
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
    let registers = |base, number| Registers(Place { base, number });
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

impl Memory for Place {
    fn number(&self) -> BankNumber {
        self.number
    }

    fn supply_is_low(&self) -> bool {
        PWR.sr2().read().pvdo()
    }

    fn address_to_program(&mut self, offset: u32) -> u32 {
        self.base + offset
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
