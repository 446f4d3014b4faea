//! The sensor board: STM32G474RE at 170 MHz. One file a peripheral; the pin map is in `pins` and in the README.
#![allow(unsafe_code)] // start-up, interrupts, priorities

mod ccm;
mod checksum;
mod clocks;
mod flash;
mod last_look;
mod pins;
mod reading;
mod sampling;
mod serial;
mod slow_clock;
mod spi;
mod supervision;

use self::clocks::Delay;
use self::flash::Flash;
pub(super) use self::last_look::put_back as at_look;
use self::pins::Pin;
use self::reading::{NoFrames, Reading};
use self::serial::Serial;
use self::spi::Device;
use super::interrupt::{BELOW_SAMPLING, Owned, SAMPLING as SAMPLING_PRIORITY};
use super::main_loop::{self, Board, RATE_HZ, WATCHDOG_MS};
use super::start;
use super::{fault, guard, hang, intake, rtt, watchdog};
use crate::app::background::Background;
use crate::app::console::Console;
use crate::app::sampler::{Sampler, missed_between};
use crate::app::updates::Updater;
use crate::drivers::ad7606c::ChipError;
use crate::drivers::converter::{Converter, ConverterError, Settings};
use crate::selftest::Answers;
use crate::update::install::Rules;
use crate::update::version::Version;
use crate::update::{header, journal, key, standing, trial};
use core::mem::MaybeUninit;
use cortex_m::peripheral::{DWT, NVIC};
use cortex_m_rt::exception;
use embedded_hal::spi::ErrorKind;
use stm32_metapac::{Interrupt, interrupt};

/// What the board is called, on the link and in an image's header.
const NAME: &str = "g474";

type Chips = Converter<Device, Device, Pin, Pin, Pin>;

/// What the two sampling interrupts own: that of BUSY's edge and that of a reading's end. Both have the same priority.
struct Sampling {
    converter: Chips,
    reading: Reading,
    sampler: Sampler<'static, 'static>,
    /// The last instant that was served.
    served: u32,
    /// The instant of the reading that is under way.
    instant: u32,
}

static SAMPLING: Owned<Sampling> = Owned::empty();
/// What the serial interrupt owns.
static SERIAL: Owned<serial::Interrupt> = Owned::empty();

/// Instants without a sample after which the converter counts as silent: more than pass while a reading that hangs is given up
/// ([`HUNG_INSTANTS`], and its own) behind two that a debugger's halt has left out. With fewer it was given up by hand, beside the start of
/// the next reading: two instants' work in one.
const SILENT_INSTANTS: u32 = 6;

/// Instants after its own at which a reading that has not ended will not end any more: it takes 6.8 us.
const HUNG_INSTANTS: u32 = 2;

/// BUSY has fallen: one sampling instant, whose reading is started. Above it is only what ends in a restart.
#[interrupt]
fn EXTI9_5() {
    let asked = sampling::acknowledge();
    // SAFETY: the sampling interrupts own it, and none interrupts the other.
    let Some(own) = (unsafe { SAMPLING.get() }) else {
        return;
    };
    if asked && own.converter.in_service() && own.reading.is_ready() {
        own.instant = sampling::instants();
        own.reading.begin();
    } else {
        own.isr_without_reading(asked);
    }
}

/// Both chips' frames are there.
#[interrupt]
fn DMA1_CHANNEL2() {
    let entered = DWT::cycle_count();
    // SAFETY: as above.
    let Some(own) = (unsafe { SAMPLING.get() }) else {
        return;
    };
    own.isr_compute();
    own.note_cycles(entered);
}

/// A bus's peripheral did not answer.
const BUS_SILENT: ChipError = ChipError::Bus(ErrorKind::Other);
/// A reading did not end as it should.
const UNREAD: ConverterError = ConverterError::Chip {
    index: 1,
    error: BUS_SILENT,
};
/// BUSY made no edge.
const SILENT: ConverterError = ConverterError::BusyStuck { polls: 0 };

impl Sampling {
    /// Checks and decodes both frames and computes the sample.
    #[inline(always)]
    fn isr_compute(&mut self) {
        let frames = self.reading.finish();
        // Called for a transfer that was given up meanwhile.
        if matches!(frames, Err(NoFrames::NotBegun)) {
            return;
        }
        let Some(missed) = missed_between(self.served, self.instant) else {
            return;
        };
        self.served = self.instant;
        let raw = self.sampler.isr_raw();
        let is_good = match frames {
            Ok(frames) => self.converter.receive(frames, checksum::of, raw),
            Err(_) => {
                self.converter.refuse(UNREAD, raw);
                false
            }
        };
        if !is_good {
            self.reading.doubt();
        }
        self.sampler.isr_compute(missed, |_| {});
        intake::isr_call();
    }

    /// An instant without frames: called by hand, since BUSY made no edge; while the chips are set again, a piece at a time; when a
    /// reading does not end; or after one that had a byte too many or too few, while the buses are made ready again. A call during a
    /// reading that has just begun is no error: a debugger's halt may leave some, and their instants count as missed.
    #[cold]
    #[inline(never)]
    fn isr_without_reading(&mut self, asked: bool) {
        let entered = DWT::cycle_count();
        // By hand while a conversion may be under way: its own edge is still to come, and would be served a second time.
        if !asked && !sampling::is_settled() {
            return;
        }
        let now = sampling::instants();
        if self.reading.is_under_way() && now.wrapping_sub(self.instant) < HUNG_INSTANTS {
            return;
        }
        let Some(missed) = missed_between(self.served, now) else {
            return;
        };
        self.served = now;
        if !self.converter.in_service() {
            self.isr_set_anew(missed);
            return self.note_cycles(entered);
        }
        let error = if asked { UNREAD } else { SILENT };
        self.converter.refuse(error, self.sampler.isr_raw());
        if self.converter.in_service() {
            self.reading.make_ready();
        }
        self.isr_conclude(missed);
        self.note_cycles(entered);
    }

    /// A piece of setting the chips again: the bus exchanges a frame while the sample is computed.
    #[cold]
    #[inline(never)]
    fn isr_set_anew(&mut self, missed: u32) {
        self.reading.by_hand();
        self.sampler.isr_raw().fault = self.converter.error().status();
        let Some(exchange) = self.converter.begin_piece() else {
            return self.isr_conclude(missed);
        };
        let begun = spi::begin(exchange.chip, exchange.command.bytes());
        self.isr_conclude(missed);
        let reply = begun.end().map_err(|_| BUS_SILENT);
        self.converter.end_piece(&exchange, reply);
    }

    /// Computes the sample of an instant without frames.
    #[inline(never)]
    fn isr_conclude(&mut self, missed: u32) {
        self.sampler.isr_compute(missed, |_| {});
        intake::isr_call();
    }

    /// Notes how long an interrupt took that has entered at this count. What only starts a reading is not counted: it always takes the same.
    #[inline(always)]
    fn note_cycles(&self, entered: u32) {
        let spent = DWT::cycle_count().wrapping_sub(entered);
        self.sampler.mailbox().note_isr_cycles(spent);
    }
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
    answers: Answers,
}

impl Board for G474 {
    fn feed(&mut self) {
        watchdog::feed();
    }

    fn wake_silent_converter(&mut self) {
        let (samples, now) = (self.mailbox.samples(), sampling::instants());
        if samples != self.samples_seen {
            self.samples_seen = samples;
            self.seen_at = now;
        } else if now.wrapping_sub(self.seen_at) >= SILENT_INSTANTS && sampling::is_settled() {
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

    fn unanswered(&mut self) -> Option<i32> {
        let [asked, answered] = sampling::asked_and_answered()?;
        Some(self.answers.look(asked, answered))
    }

    fn at_mark(&mut self) -> bool {
        // Pulled up: a switch to ground, or an open collector. A broken wire is no mark.
        pins::MARK.is_grounded()
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
    ccm::load();
    guard::start();
    // The first stage has started it; without one, first of all: from here to the main loop are some milliseconds.
    watchdog::start(WATCHDOG_MS as u16);
    clocks::start();
    let sets = start::configurations();
    let (background, console, running) = set_up(sets);
    offer_updates(background, running);
    let board = G474 {
        samples_seen: 0,
        mailbox: background.mailbox(),
        seen_at: 0,
        answers: Answers::default(),
    };
    sampling::start(RATE_HZ);
    hang::start(clocks::CLOCK_HZ);
    last_look::start();
    main_loop::run(board, background, console)
}

/// Both halves of the main loop, and the bank that code runs from.
type Halves = (
    &'static mut Background<'static, 'static, Serial, Flash>,
    &'static mut Console<'static, rtt::Rings>,
    Flash,
);

/// Takes new firmware from now on. A function of its own, as the set-up is.
#[inline(never)]
fn offer_updates(background: &mut Background<'static, 'static, Serial, Flash>, mut running: Flash) {
    background.offer_updates(|other| updates(&mut running, other));
}

/// Brings both banks in order before anybody looks into the slots, and says how the image that runs stands.
#[inline(never)]
fn updates(running: &mut Flash, other: &mut Flash) -> &'static mut Updater {
    let (near, standing) = (standing::read(running), trial::start(running, other));
    match (standing.trial, standing.moved) {
        (Some(number), _) => defmt::info!("image {=u32} is on trial", number),
        (None, Err(_)) => defmt::error!("the calibration could not be moved beside this image"),
        (None, Ok(())) => {}
    }
    let version = near.header.map_or(Version::OWN, |header| header.version);
    let rules = Rules {
        board: header::board(NAME),
        version,
        key: key::TRUSTED,
        allow_older: false,
    };
    cortex_m::singleton!(: Updater = Updater::new(&near, rules, standing)).expect("called once")
}

/// Everything but the sampling instants. A function of its own: the main loop's stack begins where this one's began.
#[inline(never)]
fn set_up(sets: &'static mut start::Configurations) -> Halves {
    pins::start();
    let rings = rtt::start();
    let (mut running, other) = flash::take();
    let image = journal::installed(&mut running).unwrap_or(0);
    let mut report = fault::take(supervision::take_reset_cause(), image);
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
    pins::hand_to_timers();
    checksum::start();
    let mut reading = Reading::start();
    if converter.in_service() {
        reading.make_ready();
    }
    let received = cortex_m::singleton!(: serial::ReceiveQueue = serial::ReceiveQueue::new())
        .expect("called once");
    let to_send =
        cortex_m::singleton!(: serial::SendQueue = serial::SendQueue::new()).expect("called once");
    let (serial_interrupt, serial) = serial::start(received, to_send);
    let parts = (serial, other);
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
        (NAME, supervision::device()),
        report,
    );
    // SAFETY: the interrupts are enabled afterwards.
    unsafe {
        SAMPLING.put(Sampling {
            converter,
            reading,
            sampler,
            served: sampling::FIRST.wrapping_sub(1),
            instant: sampling::FIRST,
        });
        SERIAL.put(serial_interrupt);
        let mut processor = cortex_m::Peripherals::steal();
        processor.DCB.enable_trace();
        processor.DWT.enable_cycle_counter();
        for line in [Interrupt::EXTI9_5, Interrupt::DMA1_CHANNEL2] {
            processor.NVIC.set_priority(line, SAMPLING_PRIORITY);
            NVIC::unmask(line);
        }
        processor
            .NVIC
            .set_priority(Interrupt::USART1, BELOW_SAMPLING);
        NVIC::unmask(Interrupt::USART1);
    }
    (background, console, running)
}
