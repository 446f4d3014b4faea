//! The first stage: runs before the `g474` firmware at every reset, from the first pages of bank 1, and starts the bank that
//! [`choose`](crate::update::choice::choose) names.
//!
//! It is written once, by a debug probe, and no update touches it. It copies itself into RAM ([`start`]), so that the banks can change places
//! under it, and it writes nothing but the mark of a trial, into the bank that is then the other one. No interrupt is on, the clock is the one
//! after reset, and the watchdog runs from the first moment: what hangs here, or in an image that is started, ends in a reset.
#![allow(unsafe_code)] // memory, registers, and a jump to an image

mod banks;
mod start;

use self::banks::{bank, is_laid_out, is_whole, swap};
use super::watchdog;
use crate::drivers::g4_flash::BankNumber;
use crate::update::choice::choose;
use crate::update::layout::BODY_START;
use core::ptr::{read_volatile, write_volatile};
use stm32_metapac::{FLASH, RCC};

/// Where the bank that runs begins (RM0440, memory map).
const RUNNING: u32 = 0x0800_0000;
/// Vector table's place (ARM DDI 0403, B3.2.5).
const VTOR: *mut u32 = 0xE000_ED08 as *mut u32;
/// Both longest ways through this file take some 60 ms; the same time as the firmware's own watchdog.
const WATCHDOG_MS: u16 = 1000;
/// SRAM1 and SRAM2. This program's own RAM (`link.x`) is behind them.
const RAM: core::ops::Range<u32> = 0x2000_0000..0x2001_8000;
/// The first word of the identifier by which a host finds the rings of the debug link in RAM: "SEGG".
const RINGS: u32 = u32::from_le_bytes(*b"SEGG");

/// Everything, once the code is in RAM.
extern "C" fn main() -> ! {
    watchdog::start(WATCHDOG_MS);
    RCC.apb2enr().modify(|w| w.set_syscfgen(true));
    RCC.ahb1enr().modify(|w| w.set_crcen(true));
    let access = without_caches();
    forget_rings();
    let bank = chosen_bank();
    RCC.ahb1enr().modify(|w| w.set_crcen(false));
    swap(bank == BankNumber::Two);
    FLASH.acr().write_value(access);
    hand_over(RUNNING + BODY_START)
}

/// The bank to start. Without a whole image there is nothing to start: the watchdog tries anew, and a debug probe can still write the board.
fn chosen_bank() -> BankNumber {
    if !is_laid_out() {
        // Banks that cannot change places: the code is where this program is.
        return BankNumber::One;
    }
    let numbers = [BankNumber::One, BankNumber::Two];
    let mut banks = numbers.map(bank);
    match choose(&mut banks, is_whole) {
        Some(candidate) if candidate.bank == 0 => BankNumber::One,
        Some(_) => BankNumber::Two,
        None => wait_for_reset(),
    }
}

/// Switches prefetch and caches off and empties these: what they hold would be the other bank's once both change places. What the register
/// held before.
fn without_caches() -> stm32_metapac::flash::regs::Acr {
    let before = FLASH.acr().read();
    let mut off = before;
    off.set_prften(false);
    off.set_icen(false);
    off.set_dcen(false);
    FLASH.acr().write_value(off);
    let mut empty = off;
    empty.set_icrst(true);
    empty.set_dcrst(true);
    FLASH.acr().write_value(empty);
    FLASH.acr().write_value(off);
    before
}

/// Takes the identifier of the debug link's rings out of RAM. They lie elsewhere in another image, and a host that looks too early would take
/// those of the image before for its own.
fn forget_rings() {
    for place in RAM.step_by(4) {
        let place = place as *mut u32;
        // SAFETY: RAM that nobody uses now; the image that starts sets up all but what is kept over a reset, which holds no such word.
        unsafe {
            if read_volatile(place) == RINGS {
                write_volatile(place, 0);
            }
        }
    }
}

/// Starts the image whose vectors lie here, with the registers as they are after a reset.
fn hand_over(vectors: u32) -> ! {
    RCC.apb2enr().modify(|w| w.set_syscfgen(false));
    // SAFETY: the vectors of an image whose check value is right, or of the only one there is; nothing of this program is used afterwards.
    unsafe {
        write_volatile(VTOR, vectors);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        cortex_m::asm::bootload(vectors as *const u32)
    }
}

/// The watchdog resets the chip.
fn wait_for_reset() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// Wrong check bits of a double word that is read are noted; anything else is a fault.
extern "C" fn isr_nmi() {
    if !banks::isr_torn() {
        wait_for_reset();
    }
}

extern "C" fn isr_fault() {
    wait_for_reset();
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    wait_for_reset()
}
