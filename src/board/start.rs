//! Start-up that every board shares: statics, both halves of the firmware, the queues between them.

use super::intake;
use super::main_loop::RATE_HZ;
use super::memory;
use super::once::Once;
use super::rtt::{Rings, Stream};
use crate::app::background::Background;
use crate::app::console::Console;
use crate::app::frames::{FramePlaces, FrameQueue, QUEUE_FRAMES};
use crate::app::intake::{Intake, OrderQueue};
use crate::app::restarts::StartReport;
use crate::app::sampler::{Mailbox, Sampler};
use crate::app::task::Task;
use crate::app::watcher::Watcher;
use crate::calibration::slots::Slots;
use crate::device::Device;
use crate::drivers::converter::{Converter, ConverterError};
use crate::drivers::motion::MotionPort;
use crate::link::message::{ConverterTest, Hello, MemoryTest, PROTOCOL};
use crate::link::telemetry::StreamOrder;
use crate::settings::Settings;
use crate::step::{StepConfig, StepState};
use crate::swap::SwapQueues;
use crate::teeth::ToothMap;
use crate::update::layout::SLOTS_START;
use core::mem::MaybeUninit;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;
use heapless::String;
use heapless::spsc::Consumer;

/// Attempts at setting the converters up; after that status and frames say what is wrong.
const ATTEMPTS: u32 = 3;

/// The sessions' memory.
static TASK: Once<Task> = Once::new(Task::Idle);

/// What the watch over the calibration keeps beside its window, which lies in the sessions' memory.
static WATCHER: Once<Watcher> = Once::new(Watcher::new());

/// Both sets of coefficients.
static CONFIGS: Once<Configurations> = Once::new([StepConfig::UNSET; 2]);

/// In force, and spare.
pub type Configurations = [StepConfig; 2];

/// The firmware's parts, connected.
pub struct Ends<S: 'static, F: 'static> {
    /// For the sampling interrupt.
    pub sampler: Sampler<'static, 'static>,
    /// For the main loop.
    pub background: &'static mut Background<'static, 'static, S, F>,
    /// For the main loop.
    pub console: &'static mut Console<'static, Rings>,
}

/// Where the background lives: the board's own static, since it knows the types, and too large for a stack.
pub type BackgroundPlace<S, F> = &'static mut MaybeUninit<Background<'static, 'static, S, F>>;

/// Sets the converters up and tells how their self-test went; what fails is logged.
pub fn initialise<A, B, C, R, I>(
    converter: &mut Converter<A, B, C, R, I>,
    delay: &mut impl DelayNs,
) -> ConverterTest
where
    A: SpiDevice,
    B: SpiDevice,
    C: OutputPin,
    R: OutputPin,
    I: InputPin,
{
    let mut tested = ConverterTest::NotRun;
    for attempt in 1..=ATTEMPTS {
        let result = converter.initialise(delay);
        tested = result.into();
        match result {
            Ok(()) => {
                defmt::info!("converters ready");
                break;
            }
            Err(error) => defmt::error!("converters, attempt {=u32}: {}", attempt, name(&error)),
        }
    }
    tested
}

fn name(error: &ConverterError) -> &'static str {
    match error {
        ConverterError::Chip { .. } => "a chip does not answer as it should",
        ConverterError::Pin(_) => "a pin cannot be driven",
        ConverterError::BusyNeverRose { .. } => "BUSY did not rise",
        ConverterError::BusyStuck { .. } => "BUSY did not fall",
    }
}

/// Says why the board started.
pub fn log(report: &StartReport) {
    match &report.fault {
        None => defmt::info!("start, cause {}", report.cause),
        Some(fault) => defmt::error!(
            "start after a fault, cause {}, at {=u32:#x}, {=u32} s after its start: {=str}",
            report.cause,
            fault.program_counter,
            fault.uptime_s,
            fault.message.as_str()
        ),
    }
}

/// Tests the background's memory and connects both halves. To be called once; [`main_loop::run`](super::main_loop::run) looks into the slots.
///
/// # Panics
/// On a second call, before sampling begins.
pub fn connect<S, F>(
    place: BackgroundPlace<S, F>,
    parts: (S, F),
    (rings, stream): (Rings, Stream),
    sets: &'static mut Configurations,
    (board, device): (&str, Device),
    mut report: StartReport,
) -> Ends<S, F>
where
    S: Read + ReadReady + Write + WriteReady + 'static,
    F: NorFlash + 'static,
{
    report.health.memory = memory::test(place);
    if report.health.memory != MemoryTest::Passed {
        defmt::error!("memory does not keep what is written");
    }
    let (console, orders) = introduced(rings, board, device, report);
    assemble(place, parts, sets, (console, orders, stream), device)
}

/// The console of a board that says who it is, in its place, and the orders that it passes to the intake.
#[inline(never)]
fn introduced(
    rings: Rings,
    board: &str,
    device: Device,
    report: StartReport,
) -> (
    &'static mut Console<'static, Rings>,
    Consumer<'static, StreamOrder>,
) {
    let hello = Hello {
        protocol: PROTOCOL,
        firmware: String::try_from(env!("CARGO_PKG_VERSION")).unwrap_or_default(),
        board: String::try_from(board).unwrap_or_default(),
        device,
        rate_hz: RATE_HZ as f32,
    };
    let (streams, orders) = cortex_m::singleton!(: OrderQueue = OrderQueue::new())
        .expect("called once")
        .split();
    let console =
        cortex_m::singleton!(: MaybeUninit<Console<'static, Rings>> = MaybeUninit::uninit());
    let console = console
        .expect("called once")
        .write(Console::new(rings, streams, hello, report));
    (console, orders)
}

/// The console, and what the intake needs of the link.
type LinkEnds = (
    &'static mut Console<'static, Rings>,
    Consumer<'static, StreamOrder>,
    Stream,
);

fn own_settings() -> Settings {
    Settings {
        rate_hz: RATE_HZ as f32,
        ..Settings::default()
    }
}

#[inline(never)] // what this takes of the stack, `introduced` may take as well
fn assemble<S, F>(
    place: BackgroundPlace<S, F>,
    (serial, flash): (S, F),
    [active, spare]: &'static mut Configurations,
    (console, orders, stream): LinkEnds,
    device: Device,
) -> Ends<S, F>
where
    S: Read + ReadReady + Write + WriteReady + 'static,
    F: NorFlash + 'static,
{
    let queues =
        cortex_m::singleton!(: SwapQueues<'static> = SwapQueues::new()).expect("called once");
    // By its name the linker puts it into the CCM RAM (`memory.x`).
    static FRAME_PLACES: Once<FramePlaces> =
        Once::new([const { StepState::ZERO }; QUEUE_FRAMES + 1]);
    let places = FRAME_PLACES.take().expect("called once");
    let frames = cortex_m::singleton!(: FrameQueue<'static> = FrameQueue::new());
    let frames = frames.expect("called once");
    let mailbox: &'static Mailbox =
        cortex_m::singleton!(: Mailbox = Mailbox::new()).expect("called once");
    static MAP: Once<ToothMap> = Once::new(ToothMap::new());
    let map = MAP.take().expect("called once");
    let (sender, receiver) = queues.split(active, spare, map);
    let (produce, take, consume) = frames.split(places);
    intake::start(Intake::new(take, orders, mailbox, stream));
    let motion = MotionPort::new(serial);
    let background = place.write(Background::new(
        (consume, sender, mailbox),
        motion,
        Slots::new(flash, SLOTS_START),
        own_settings(),
        device,
        (
            TASK.take().expect("called once"),
            WATCHER.take().expect("called once"),
        ),
    ));
    Ends {
        sampler: Sampler::new(receiver, produce, mailbox),
        background,
        console,
    }
}

/// Both sets of coefficients by the board's own settings. To be called once, and before [`connect`]: what it takes of the stack does not
/// come on top of that.
///
/// # Panics
/// On a second call.
#[inline(never)]
pub fn configurations() -> &'static mut Configurations {
    let settings = own_settings();
    let sets = CONFIGS.take().expect("called once");
    for set in &mut *sets {
        // Without the error's own text: its numbers would bring float formatting into the image.
        if set.set(&settings).is_err() {
            panic!("the board's own settings are out of range");
        }
    }
    sets
}
