//! Sees a hang shortly before the watchdog does, and keeps where it is: a reset by the watchdog itself leaves no place.
//!
//! The chip's independent watchdog gives no warning, so the processor's own timer looks at every [`LOOK_MS`] whether the main loop has come
//! round. Its priority is above every critical section and below the sampling interrupt: one that does not end is seen where a
//! board can ([`super::at_look`]).
#![allow(unsafe_code)] // exception handlers

use super::fault;
use super::interrupt::LOOK;
use crate::link::message::ResetCause;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SCB};

/// Without progress of interrupt and background for so long the watchdog restarts the board.
pub const WATCHDOG_MS: u32 = 1000;
/// From one look to the next: at 170 MHz the timer's 24 bits last 98 ms.
const LOOK_MS: u32 = 50;
/// Looks without progress that are a hang. The watchdog's oscillator is 6 % fast at most (data sheet DS12288: 34 kHz), so that it ends a
/// second after 0.94 s; the last look is 850 to 900 ms after the last progress.
const LOOKS: u32 = 17;
const _: () = assert!((LOOKS + 1) * LOOK_MS < WATCHDOG_MS * 32 / 34);

/// The main loop has come round since the last look.
static PROGRESS: AtomicBool = AtomicBool::new(false);
/// Looks since then.
static QUIET: AtomicU32 = AtomicU32::new(0);

/// Starts the looks; the processor runs at `clock_hz`. To be called before the main loop.
pub fn start(clock_hz: u32) {
    PROGRESS.store(true, Relaxed);
    // SAFETY: the timer and its priority, which nobody else uses; its handler shares no memory with anybody.
    unsafe {
        let mut processor = Peripherals::steal();
        processor.SCB.set_priority(SystemHandler::SysTick, LOOK);
        processor.SYST.set_clock_source(SystClkSource::Core);
        processor.SYST.set_reload(clock_hz / 1000 * LOOK_MS - 1);
        processor.SYST.clear_current();
        processor.SYST.enable_interrupt();
        processor.SYST.enable_counter();
    }
}

/// The main loop has come round, and the interrupt has sampled.
pub fn note_progress() {
    PROGRESS.store(true, Relaxed);
}

/// The processor's timer. Gives its look the place where the processor pushed what it was at.
#[unsafe(naked)]
#[unsafe(no_mangle)]
#[allow(non_snake_case)] // the vector's name
extern "C" fn SysTick() {
    core::arch::naked_asm!("mrs r0, msp", "b {look}", look = sym isr_look);
}

/// One look. `place` is the exception's frame.
extern "C" fn isr_look(place: u32) {
    super::at_look();
    if PROGRESS.load(Relaxed) {
        PROGRESS.store(false, Relaxed);
        QUIET.store(0, Relaxed);
        return;
    }
    let quiet = QUIET.load(Relaxed) + 1;
    QUIET.store(quiet, Relaxed);
    if quiet >= LOOKS {
        isr_keep(place);
    }
}

/// Keeps the place of a hang for the next start, and restarts. `place` is the frame of the exception that found it.
pub extern "C" fn isr_keep(place: u32) -> ! {
    keep(place);
    SCB::sys_reset();
}

/// Keeps the place of a hang for the next start. `place` is the frame of the exception that found it.
pub fn keep(place: u32) {
    let (program_counter, link_register) = fault::interrupted(place);
    fault::keep(
        ResetCause::Watchdog,
        program_counter,
        link_register,
        b"no progress of interrupt or background",
    );
}
