//! The emulated board: QEMU's mps2-an386. SPI, pins, serial line and flash are questions to the host ([`crate::emulation`]).
#![allow(unsafe_code)] // start-up, vectors, priorities

mod ahead;
mod clock;
mod mailbox;
mod parts;

use self::clock::Delay;
use self::mailbox::Mailbox as Post;
use self::parts::{Flash, Line, Serial, Spi};
use super::interrupt::{self, Owned};
use super::main_loop::{self, Board, RATE_HZ, WATCHDOG_MS};
use super::start::{self, Ends};
use super::{fault, guard, hang, intake, rtt};
use crate::app::background::Background;
use crate::app::console::Console;
use crate::app::sampler::{Sampler, missed_between};
use crate::device::Device;
use crate::drivers::converter::{Converter, ConverterError, Counts, Settings};
use crate::emulation::{BACKGROUND, INTERRUPT, Operation, Pin, TICK_HZ};
use crate::link::message::ResetCause;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use cortex_m::peripheral::NVIC;

type Chips = Converter<Spi, Spi, Line, Line, Line>;

/// What the sampling interrupt owns.
static SAMPLING: Owned<(Chips, Sampler<'static, 'static>)> = Owned::empty();

/// The sampling interrupt has run: what the background sleeps for.
static SAMPLED: AtomicBool = AtomicBool::new(false);

/// Level of the reference mark's input at the last conversion.
static AT_MARK: AtomicBool = AtomicBool::new(false);

/// CMSDK timer 0.
#[derive(Clone, Copy)]
struct Timer;

// SAFETY: the timer's line on this machine.
unsafe impl cortex_m::interrupt::InterruptNumber for Timer {
    fn number(self) -> u16 {
        8
    }
}

/// Vectors of the machine's lines.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [extern "C" fn(); 16] = {
    let mut vectors = [unused as extern "C" fn(); 16];
    vectors[8] = isr_sampling;
    vectors
};

extern "C" fn unused() {}

/// One sampling instant. The highest priority there is.
extern "C" fn isr_sampling() {
    clock::acknowledge();
    // SAFETY: this interrupt owns it.
    let Some((converter, sampler)) = (unsafe { SAMPLING.get() }) else {
        return;
    };
    let Some(missed) = missed_between(0, clock::take_instants(RATE_HZ)) else {
        return;
    };
    let reading = isr_convert(converter);
    sampler.isr_sample(reading, missed);
    intake::isr_call();
    SAMPLED.store(true, Relaxed);
}

/// What the timer's pulse does on the real board is one question here; then both chips are read.
fn isr_convert(converter: &mut Chips) -> Result<Counts, ConverterError> {
    const PERIOD: u32 = clock::period(RATE_HZ);
    let ask = || Post::new(INTERRUPT).ask(Operation::Convert, PERIOD, &[], &mut []);
    let answer =
        ahead::take_conversion(clock::ticks(), PERIOD).unwrap_or_else(|| ask().unwrap_or(0));
    parts::BYTES_WAIT.store(answer & 2 != 0, Relaxed);
    AT_MARK.store(answer & 4 != 0, Relaxed);
    if answer & 1 == 0 {
        return Err(converter.silent());
    }
    let mut counts = Counts::default();
    converter.read(&mut counts).map(|()| counts)
}

/// The watchdog's warning, one period before its reset. Gives its handler the place where the processor pushed what it was at.
#[unsafe(naked)]
#[unsafe(no_mangle)]
#[allow(non_snake_case)] // the vector's name
extern "C" fn NonMaskableInt() -> ! {
    core::arch::naked_asm!("mrs r0, msp", "b {warned}", warned = sym warned);
}

/// Keeps the place, and waits for the reset.
extern "C" fn warned(place: u32) -> ! {
    hang::keep(place);
    loop {
        cortex_m::asm::nop();
    }
}

struct Emulated {
    post: Post,
}

impl Board for Emulated {
    fn feed(&mut self) {
        clock::feed();
    }

    fn wake_silent_converter(&mut self) {
        // The timer itself interrupts here.
    }

    fn set_led(&mut self, on: bool) {
        let _ = self.post.ask(
            Operation::SetPin,
            2 * Pin::Led as u32 + u32::from(on),
            &[],
            &mut [],
        );
    }

    fn temperature_c(&mut self) -> Option<f32> {
        let word = self
            .post
            .ask(Operation::Temperature, 0, &[], &mut [])
            .ok()?;
        Some((word.cast_signed() - 1_000_000) as f32 * 1.0e-3)
    }

    fn unanswered(&mut self) -> Option<i32> {
        None
    }

    fn at_mark(&mut self) -> bool {
        AT_MARK.load(Relaxed)
    }

    fn sleep(&mut self) {
        while !SAMPLED.swap(false, Relaxed) {
            clock::pause();
        }
    }
}

/// Start-up and main loop.
pub fn main() -> ! {
    let post = Post::new(BACKGROUND);
    guard::start();
    let sets = start::configurations();
    let (background, console) = set_up(post, sets);
    clock::start_sampling(RATE_HZ);
    hang::start(TICK_HZ);
    main_loop::run(Emulated { post }, background, console)
}

type Halves = (
    &'static mut Background<'static, 'static, Serial, Flash>,
    &'static mut Console<'static, rtt::Rings>,
);

/// Everything but the sampling instants. A function of its own: the main loop's stack begins where this one's began.
#[inline(never)]
fn set_up(post: Post, sets: &'static mut start::Configurations) -> Halves {
    clock::start_counter();
    let mut number = *b"emulated\0\0\0\0"; // unless the host says another
    let _ = post.ask(Operation::Boot, 0, &[], &mut number);
    let rings = rtt::start();
    // What the chip's flags would say after a start and after the supply was cut.
    let mut report = fault::take(ResetCause::BrownOut, 0);
    start::log(&report);
    let line = |pin| Line {
        mailbox: Post::new(INTERRUPT),
        pin,
    };
    let spi = |chip| Spi {
        mailbox: Post::new(INTERRUPT),
        chip,
    };
    let lines = (line(Pin::Convst), line(Pin::Reset), line(Pin::Busy));
    let mut converter =
        Converter::new((spi(0), spi(1)), lines.0, lines.1, lines.2, Settings::BOARD);
    report.health.converters = start::initialise(&mut converter, &mut Delay);
    let parts = (Serial::new(post), Flash { mailbox: post });
    let place = cortex_m::singleton!(: MaybeUninit<Background<'static, 'static, Serial, Flash>> = MaybeUninit::uninit());
    let place = place.expect("called once");
    let Ends {
        sampler,
        background,
        console,
    } = start::connect(
        place,
        parts,
        rings,
        sets,
        ("emulated", Device(number)),
        report,
    );
    clock::start_watchdog(WATCHDOG_MS * 1000);
    // SAFETY: the interrupt is enabled afterwards.
    unsafe {
        SAMPLING.put((converter, sampler));
        let mut processor = cortex_m::Peripherals::steal();
        processor.NVIC.set_priority(Timer, interrupt::SAMPLING);
        NVIC::unmask(Timer);
    }
    (background, console)
}
