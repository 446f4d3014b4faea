//! Both banks for a program that runs from RAM: each is read where it lies, and is made the other one before it is written.

use crate::board::flash_controller::{Memory, Registers, options};
use crate::drivers::g4_flash::{self, Bank, BankNumber};
use crate::update::header::{CRC32_INITIAL, CRC32_POLYNOMIAL, Header};
use crate::update::layout::BODY_START;
use core::ptr::read_volatile;
use core::sync::atomic::{AtomicBool, Ordering::SeqCst};
use stm32_metapac::crc::vals::{RevIn, RevOut};
use stm32_metapac::{CRC, FLASH, SYSCFG};

/// Where the bank that runs begins, and the other one (RM0440, memory map).
const NEAR: u32 = 0x0800_0000;
const FAR: u32 = 0x0804_0000;

/// Wrong check bits were met since the last look.
static TORN: AtomicBool = AtomicBool::new(false);

/// One of the banks.
pub struct Place(BankNumber);

/// The bank of this number.
pub fn bank(number: BankNumber) -> Bank<Registers<Place>> {
    Bank::new(Registers(Place(number)))
}

/// Whether the option bytes lay the flash out as two banks.
pub fn is_laid_out() -> bool {
    g4_flash::is_laid_out(options())
}

/// Makes the banks change places, or takes that back. Nothing may run from them, and the caches must be off and empty.
pub fn swap(swapped: bool) {
    SYSCFG.memrmp().modify(|w| w.set_fb_mode(swapped));
    // The next access finds them there.
    while SYSCFG.memrmp().read().fb_mode() != swapped {}
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// For the non-maskable interrupt: true if wrong check bits were its cause. This program's own code is in RAM: they are always of data.
pub fn isr_torn() -> bool {
    let torn = FLASH.eccr().read().eccd();
    FLASH.eccr().modify(|w| w.set_eccd(true));
    TORN.store(true, SeqCst);
    torn
}

/// Whether the body is there, by the chip's unit for check values: a word takes it four cycles.
pub fn is_whole(bank: &mut Bank<Registers<Place>>, header: &Header) -> bool {
    CRC.init().write_value(CRC32_INITIAL);
    CRC.pol().write_value(CRC32_POLYNOMIAL);
    CRC.cr().write(|w| {
        w.set_rev_in(RevIn::WORD);
        w.set_rev_out(RevOut::REVERSED);
        w.set_reset(true);
    });
    TORN.store(false, SeqCst);
    let start = bank.controller().0.base() + BODY_START;
    for place in (start..start + header.body_bytes).step_by(4) {
        // SAFETY: within the bank, since a header of another length is none.
        CRC.dr32()
            .write_value(unsafe { read_volatile(place as *const u32) });
    }
    cortex_m::asm::dsb();
    // CRC-32/ISCSI turns the result over in the end.
    !TORN.load(SeqCst) && !CRC.dr32().read() == header.body_crc
}

impl Place {
    /// Where the bank lies now.
    fn base(&self) -> u32 {
        match SYSCFG.memrmp().read().fb_mode() == (self.0 == BankNumber::Two) {
            true => NEAR,
            false => FAR,
        }
    }
}

impl Memory for Place {
    fn number(&self) -> BankNumber {
        self.0
    }

    /// The supply detector is not on yet. A mark that a failing supply tears is one trial fewer, and no more.
    fn supply_is_low(&self) -> bool {
        false
    }

    fn address_to_program(&mut self, offset: u32) -> u32 {
        // The bank that is written is always the other one.
        swap(self.0 == BankNumber::One);
        self.base() + offset
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        TORN.store(false, SeqCst);
        for (place, address) in bytes.iter_mut().zip(self.base() + offset..) {
            // SAFETY: within the bank, as the bank has checked.
            *place = unsafe { read_volatile(address as *const u8) };
        }
        // The last read has ended, and its interrupt has come, before anybody looks.
        cortex_m::asm::dsb();
        TORN.load(SeqCst)
    }
}
