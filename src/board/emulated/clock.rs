//! The machine's clocks: a free counter of 25 MHz, the sampling timer, the watchdog.
#![allow(unsafe_code)] // device registers

use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use embedded_hal::delay::DelayNs;

/// CMSDK timer 0: CTRL, VALUE, RELOAD, INTSTATUS (write 1 to clear); the machine's 25 MHz.
const TIMER: *mut u32 = 0x4000_0000 as *mut u32;
/// CMSDK watchdog: LOAD, VALUE, CONTROL, INTCLR.
const WATCHDOG: *mut u32 = 0x4000_8000 as *mut u32;
/// FPGAIO: PRESCALE at word 7, its counter at word 6.
const FPGAIO: *mut u32 = 0x4002_8000 as *mut u32;
const TICKS_PER_SECOND: u32 = crate::emulation::TICK_HZ;

/// Tick of the newest sampling instant that [`take_instants`] has told of; at first the timer's start.
static TAKEN_AT: AtomicU32 = AtomicU32::new(0);

/// Starts the free counter at the full rate.
pub fn start_counter() {
    // SAFETY: the prescaler's register.
    unsafe { write_volatile(FPGAIO.add(7), 0) };
}

/// Ticks of 40 ns since start, modulo 2^32.
#[inline(always)]
pub fn ticks() -> u32 {
    // SAFETY: reading the counter has no effect.
    unsafe { read_volatile(FPGAIO.add(6)) }
}

/// Ticks of the free counter between two sampling instants at `rate_hz`.
pub const fn period(rate_hz: u32) -> u32 {
    TICKS_PER_SECOND / rate_hz
}

/// Sampling instants at `rate_hz`, on the timer's interrupt.
pub fn start_sampling(rate_hz: u32) {
    let reload = period(rate_hz) - 1;
    TAKEN_AT.store(ticks(), Relaxed);
    // SAFETY: the timer's registers; counting with interrupt.
    unsafe {
        write_volatile(TIMER.add(2), reload);
        write_volatile(TIMER.add(1), reload);
        write_volatile(TIMER, 0b1001);
    }
}

/// Sampling instants that have come since the last call. For the sampling interrupt alone.
#[inline(always)]
pub fn take_instants(rate_hz: u32) -> u32 {
    let taken_at = TAKEN_AT.load(Relaxed);
    let instants = ticks().wrapping_sub(taken_at) / period(rate_hz);
    TAKEN_AT.store(taken_at.wrapping_add(instants * period(rate_hz)), Relaxed);
    instants
}

/// Takes back the timer's interrupt.
#[inline(always)]
pub fn acknowledge() {
    // SAFETY: the interrupt's flag.
    unsafe { write_volatile(TIMER.add(3), 1) };
}

/// Starts the watchdog: a warning (the non-maskable interrupt) after `period_us` without [`feed`], a reset after twice that.
pub fn start_watchdog(period_us: u32) {
    // SAFETY: the watchdog's registers; both the warning and the reset on.
    unsafe {
        write_volatile(WATCHDOG, TICKS_PER_SECOND / 1_000_000 * period_us);
        write_volatile(WATCHDOG.add(2), 0b11);
    }
}

/// Feeds it.
pub fn feed() {
    // SAFETY: any value reloads the counter.
    unsafe { write_volatile(WATCHDOG.add(3), 1) };
}

/// Waits so many ticks.
pub fn wait(wanted: u32) {
    let start = ticks();
    while ticks().wrapping_sub(start) < wanted {
        pause();
    }
}

/// Some microseconds of doing nothing. The emulator runs a row of these at once; asleep (WFI) it would hand over to
/// another thread and back for each interrupt, ten times as long.
#[inline(never)]
pub fn pause() {
    // SAFETY: touches nothing.
    unsafe { core::arch::asm!(".rept 200", "nop", ".endr", options(nomem, nostack)) };
}

/// Waits by the free counter.
#[derive(Debug)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        wait(ns.div_ceil(1_000_000_000 / TICKS_PER_SECOND));
    }
}
