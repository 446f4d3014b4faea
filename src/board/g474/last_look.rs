//! Sees a hang of a sampling interrupt, which the look at the main loop ([`crate::board::hang`]) waits for: the window watchdog.
//!
//! Each look puts it back. Without one for 194 ms it interrupts, at the one priority above sampling, and the place where the processor was is
//! kept; 3 ms later it would reset the chip by itself.
#![allow(unsafe_code)] // an exception handler

use crate::board::hang;
use crate::board::interrupt::ABOVE_SAMPLING;
use cortex_m::peripheral::{NVIC, Peripherals};
use stm32_metapac::wwdg::regs::{Cfr, Cr};
use stm32_metapac::{DBGMCU, Interrupt, RCC, WWDG as WATCHDOG};

/// No window; the early interrupt, EWI; the bus clock by 4096 and, WDGTB, 128: 3.08 ms a step (RM0440, 43.5.2).
const CONFIGURATION: Cfr = Cfr(0x7F | 1 << 9 | 7 << 11);
/// On, with 63 steps to the interrupt at 0x40 (RM0440, 43.5.1).
const FULL: Cr = Cr(0x7F | 1 << 7);

/// Starts it. It cannot be stopped again, but stands still while a debugger halts the processor.
pub fn start() {
    RCC.apb1enr1().modify(|w| w.set_wwdgen(true));
    DBGMCU.apb1lfzr().modify(|w| w.set_wwdg(true));
    WATCHDOG.cfr().write_value(CONFIGURATION);
    put_back();
    // SAFETY: its handler shares no memory with anybody; it ends in a restart.
    unsafe {
        let mut processor = Peripherals::steal();
        processor.NVIC.set_priority(Interrupt::WWDG, ABOVE_SAMPLING);
        NVIC::unmask(Interrupt::WWDG);
    }
}

/// A look has been taken.
pub fn put_back() {
    WATCHDOG.cr().write_value(FULL);
}

/// The early interrupt. Gives the handler the place where the processor pushed what it was at.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn WWDG() {
    core::arch::naked_asm!("mrs r0, msp", "b {keep}", keep = sym hang::isr_keep);
}
