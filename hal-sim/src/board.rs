//! The simulated sensor board: the firmware's own code on parts that answer on the wire, in one thread.
//!
//! One turn of [`SimBoard::sample`] is one sampling interval: the interrupt's half at its instant, then the intake, then one poll of the
//! background's half. The same seeds give the same run, bit for bit.

use crate::banks::{BOARD, Started};
pub use crate::shared_flash::{FLASH_PAGES, SharedFlash};
use crate::wire::converter::{Busy, Convst, Reset, Spi};
use crate::wire::link::LinkWire;
use crate::wire::motion::Line;
use crate::world::World;
use courier_sensor::app::background::Background;
use courier_sensor::app::console::Console;
use courier_sensor::app::frames::{FrameQueue, QUEUE_FRAMES};
use courier_sensor::app::intake::{Intake, OrderQueue};
use courier_sensor::app::restarts::StartReport;
use courier_sensor::app::sampler::{Mailbox, Sampler};
use courier_sensor::app::updates::Updater;
use courier_sensor::calibration::slots::Slots;
use courier_sensor::device::Device;
use courier_sensor::drivers::converter::{Converter, Counts, Settings as Channels};
use courier_sensor::drivers::motion::MotionPort;
use courier_sensor::frame::Frame;
use courier_sensor::link::message::{Health, Hello, PROTOCOL, ResetCause};
use courier_sensor::settings::{ConfigError, Settings};
use courier_sensor::step::{StepConfig, StepState};
use courier_sensor::swap::SwapQueues;
use courier_sensor::update::layout::SLOTS_START;
use courier_sensor::update::version::Version;

/// The board, running.
pub struct SimBoard {
    /// Everything outside the processor.
    pub world: World,
    /// The firmware's background.
    pub background: Background<'static, 'static, Line, SharedFlash>,
    /// Host's end of the debug link.
    pub link: LinkWire,
    console: Console<'static, LinkWire>,
    intake: Intake<'static, 'static, LinkWire>,
    converter: Converter<Spi, Spi, Convst, Reset, Busy>,
    sampler: Sampler<'static, 'static>,
    period_ns: u64,
    next_ns: u64,
    /// Between two looks at what changes slowly: 100 ms, as on a board.
    slow_samples: u32,
}

impl SimBoard {
    /// Switches the board on: converters set up and tested, the stored calibration in force. A self-test that fails is told by the
    /// board's status, as on a real one.
    ///
    /// The statics of a real board are leaked here, some 80 KiB a start.
    ///
    /// # Errors
    /// The settings cannot be used.
    pub fn start(
        world: World,
        flash: SharedFlash,
        settings: Settings,
    ) -> Result<Self, ConfigError> {
        Self::start_image(ResetCause::PowerOn, world, flash, settings, None)
    }

    /// [`SimBoard::start`] of a board that takes new firmware, and was off or restarts for this cause. `image`: what its first stage has
    /// started; `flash` is the other bank.
    ///
    /// # Errors
    /// The settings cannot be used.
    pub fn start_image(
        cause: ResetCause,
        world: World,
        flash: SharedFlash,
        settings: Settings,
        image: Option<&Started>,
    ) -> Result<Self, ConfigError> {
        let initial = StepConfig::build(&settings)?;
        let mut converter = Converter::new(
            (world.converter.spi(0), world.converter.spi(1)),
            world.converter.convst(),
            world.converter.reset(),
            world.converter.busy(),
            Channels::BOARD,
        );
        let tested = converter.initialise(&mut world.clock.clone());
        let started = StartReport {
            cause,
            health: Health {
                converters: tested.into(),
                ..Health::default()
            },
            ..StartReport::default()
        };
        let mailbox: &'static Mailbox = Box::leak(Box::default());
        let queues = Box::leak(Box::new(SwapQueues::new()));
        let (active, spare) = (
            Box::leak(Box::new(initial.clone())),
            Box::leak(Box::new(initial)),
        );
        let (sender, receiver) = queues.split(active, spare, Box::leak(Box::default()));
        let (up, taken, down) = Box::leak(Box::new(FrameQueue::new())).split(Box::leak(Box::new(
            [const { StepState::ZERO }; QUEUE_FRAMES + 1],
        )));
        let period_ns = (1.0e9 / f64::from(settings.rate_hz)).round() as u64;
        let rate_hz = settings.rate_hz;
        let mut background = Background::new(
            (down, sender, mailbox),
            MotionPort::new(world.motion.line()),
            Slots::new(flash, SLOTS_START),
            settings,
            world.number,
            (Box::leak(Box::default()), Box::leak(Box::default())),
        );
        if let Some(image) = image {
            let updater = Updater::new(&image.near, image.rules(), image.standing);
            background.offer_updates(|_| Box::leak(Box::new(updater)));
        }
        background.start(false);
        let link = LinkWire::new();
        let hello = hello(rate_hz, world.number, image);
        let (streams, orders) = Box::leak(Box::new(OrderQueue::new())).split();
        let console = Console::new(link.clone(), streams, hello, started);
        world.begin_sampling();
        Ok(Self {
            console,
            next_ns: world.clock.now_ns() + period_ns,
            sampler: Sampler::new(receiver, up, mailbox),
            intake: Intake::new(taken, orders, mailbox, link.clone()),
            link,
            background,
            converter,
            period_ns,
            slow_samples: (rate_hz / 10.0) as u32,
            world,
        })
    }

    /// One sampling interval: the interrupt at its instant, then one turn of the main loop.
    ///
    /// What takes seconds on the target takes no time here: it is done before the next instant.
    pub fn sample(&mut self) -> Frame {
        while self.background.work() {}
        // An instant that the background's own transfers overran is missed, as on the board.
        let late_ns = self.world.clock.now_ns().saturating_sub(self.next_ns);
        let missed = late_ns / self.period_ns;
        self.next_ns += missed * self.period_ns;
        self.world.clock.advance_to_ns(self.next_ns);
        self.next_ns += self.period_ns;
        let mut counts = Counts::default();
        let reading = self.converter.convert(&mut counts).map(|()| counts);
        let frame = self.sampler.isr_sample(reading, missed as u32);
        let temperature_c = self
            .world
            .with_courier(|courier| courier.sample().temperature_c);
        self.background.set_temperature_c(temperature_c as f32);
        self.background.set_at_mark(self.world.is_at_mark());
        self.intake.run();
        self.background.poll();
        self.console.serve(&mut self.background);
        if frame.sequence % self.slow_samples == 0 {
            self.background.keep_events(self.console.started());
        }
        frame
    }

    /// Whether the host asked for a restart, or an image on trial was not accepted in time.
    #[must_use]
    pub fn wants_restart(&mut self) -> bool {
        self.console.wants_restart() || self.background.is_trial_over()
    }

    /// Power off; the world, its courier and the flash go on.
    #[must_use]
    pub fn stop(self) -> World {
        self.world
    }
}

fn hello(rate_hz: f32, device: Device, image: Option<&Started>) -> Hello {
    let version = image.map_or(Version::OWN, Started::version);
    Hello {
        protocol: PROTOCOL,
        firmware: version.to_string().as_str().try_into().unwrap_or_default(),
        board: BOARD.try_into().unwrap_or_default(),
        device,
        rate_hz,
    }
}
