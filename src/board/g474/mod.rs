//! The sensor board: STM32G474RE at 170 MHz. One file a peripheral; the pin map is in `pins` and in the README.
#![allow(unsafe_code)] // start-up, interrupts, priorities

mod clocks;
mod flash;
mod pins;
mod sampling;
mod serial;
mod slow_clock;
mod spi;
mod supervision;

use self::clocks::Delay;
use self::flash::Flash;
use self::pins::Pin;
use self::serial::Serial;
use self::spi::Device;
use super::interrupt::{BELOW_SAMPLING, Owned, SAMPLING as SAMPLING_PRIORITY};
use super::main_loop::{self, Board, RATE_HZ};
use super::start;
use super::{fault, guard, hang, rtt};
use crate::app::background::Background;
use crate::app::console::Console;
use crate::app::sampler::{Sampler, missed_between};
use crate::drivers::converter::{Converter, ConverterError, Counts, Settings};
use core::mem::MaybeUninit;
use cortex_m::peripheral::{DWT, NVIC};
use cortex_m_rt::exception;
use stm32_metapac::{Interrupt, interrupt};

type Chips = Converter<Device, Device, Pin, Pin, Pin>;

/// What the sampling interrupt owns: the converters, its half of the firmware, and the last instant that it served.
static SAMPLING: Owned<(Chips, Sampler<'static, 'static>, u32)> = Owned::empty();
/// What the serial interrupt owns.
static SERIAL: Owned<serial::Interrupt> = Owned::empty();

/// Instants without an interrupt after which the converter counts as silent.
const SILENT_INSTANTS: u32 = 4;

/// BUSY has fallen: one sampling instant. The highest priority there is.
#[interrupt]
fn EXTI9_5() {
    let entered = DWT::cycle_count();
    let asked = sampling::acknowledge();
    // SAFETY: this interrupt owns it.
    let Some((converter, sampler, served)) = (unsafe { SAMPLING.get() }) else {
        return;
    };
    let now = sampling::instants();
    let Some(missed) = missed_between(*served, now) else {
        return;
    };
    *served = now;
    sampler.isr_sample(isr_read(converter, asked), missed);
    let spent = DWT::cycle_count().wrapping_sub(entered);
    sampler.mailbox().note_isr_cycles(spent);
}

/// The counts, if BUSY asked for them; called by hand there are none, and silent chips are set again piece by piece.
fn isr_read(converter: &mut Chips, asked: bool) -> Result<Counts, ConverterError> {
    if !asked {
        return Err(converter.silent());
    }
    let mut counts = Counts::default();
    converter.read(&mut counts).map(|()| counts)
}

#[interrupt]
fn USART1() {
    // SAFETY: this interrupt owns it.
    if let Some(serial) = unsafe { SERIAL.get() } {
        serial.serve();
    }
}

/// A torn slot's check bits. Anything else is a fault like any other: check bits of the code, the memory's parity, the clock.
#[exception]
unsafe fn NonMaskableInt() {
    assert!(
        flash::isr_ecc(),
        "non-maskable interrupt: check bits of the code or memory's parity are wrong"
    );
}

struct G474 {
    samples_seen: u32,
    mailbox: &'static crate::app::sampler::Mailbox,
    seen_at: u32,
}

impl Board for G474 {
    fn feed(&mut self) {
        supervision::feed();
    }

    fn wake_silent_converter(&mut self) {
        let (samples, now) = (self.mailbox.samples(), sampling::instants());
        if samples != self.samples_seen {
            self.samples_seen = samples;
            self.seen_at = now;
        } else if now.wrapping_sub(self.seen_at) >= SILENT_INSTANTS {
            self.seen_at = now;
            NVIC::pend(Interrupt::EXTI9_5);
        }
    }

    fn set_led(&mut self, on: bool) {
        pins::LED.level(on);
    }

    fn temperature_c(&mut self) -> Option<f32> {
        supervision::temperature_c()
    }

    fn sleep(&mut self) {
        // Not WFI: with a silent converter nothing would wake the processor, and the debug link needs its bus.
        cortex_m::asm::nop();
    }
}

type Ends = start::Ends<Serial, Flash>;

/// Start-up and main loop.
///
/// # Panics
/// On a second call.
pub fn main() -> ! {
    let (background, console) = set_up();
    let board = G474 {
        samples_seen: 0,
        mailbox: background.mailbox(),
        seen_at: 0,
    };
    sampling::start(RATE_HZ);
    hang::start(clocks::CLOCK_HZ);
    main_loop::run(board, background, console)
}

type Halves = (
    &'static mut Background<'static, 'static, Serial, Flash>,
    &'static mut Console<rtt::Rings>,
);

/// Everything but the sampling instants. A function of its own: the main loop's stack begins where this one's began.
#[inline(never)]
fn set_up() -> Halves {
    guard::start();
    // First of all, so that nothing that follows can wait for ever: from here to the main loop are some milliseconds.
    supervision::start_watchdog();
    clocks::start();
    pins::start();
    let rings = rtt::start();
    let mut report = fault::take(supervision::take_reset_cause());
    start::log(&report);
    report.health.option_bytes = Some(flash::options());
    report.health.slow_clock_hz = Some(slow_clock::measure_hz().unwrap_or(0));
    supervision::start_supply_detector();
    supervision::start_thermometer();
    spi::start();
    let chips = (Device::new(0), Device::new(1));
    let mut converter = Converter::new(
        chips,
        pins::CONVST,
        pins::RESET,
        pins::BUSY,
        Settings::BOARD,
    );
    report.health.converters = start::initialise(&mut converter, &mut Delay);
    pins::hand_convst_to_timer();
    let received =
        cortex_m::singleton!(: serial::ByteQueue = serial::ByteQueue::new()).expect("called once");
    let to_send =
        cortex_m::singleton!(: serial::ByteQueue = serial::ByteQueue::new()).expect("called once");
    let (serial_interrupt, serial) = serial::start(received, to_send);
    let parts = (serial, flash::take());
    let place = cortex_m::singleton!(: MaybeUninit<Background<'static, 'static, Serial, Flash>> = MaybeUninit::uninit());
    let place = place.expect("called once");
    let Ends {
        sampler,
        background,
        console,
    } = start::connect(place, parts, rings, "g474", supervision::device(), report);
    // SAFETY: the interrupts are enabled afterwards.
    unsafe {
        SAMPLING.put((converter, sampler, sampling::FIRST.wrapping_sub(1)));
        SERIAL.put(serial_interrupt);
        let mut processor = cortex_m::Peripherals::steal();
        processor.DCB.enable_trace();
        processor.DWT.enable_cycle_counter();
        processor
            .NVIC
            .set_priority(Interrupt::EXTI9_5, SAMPLING_PRIORITY);
        processor
            .NVIC
            .set_priority(Interrupt::USART1, BELOW_SAMPLING);
        NVIC::unmask(Interrupt::EXTI9_5);
        NVIC::unmask(Interrupt::USART1);
    }
    (background, console)
}
