//! An emulated board with its courier, the faults that can be put on them, and the host's end of the link.
//!
//! With `COURIER_TEST_BOARD=chip` it is the image as it ships on the model of its chip instead (`cargo xtask chip --tests`). Six tests are
//! not run there, since what they put on the mailboxes of the emulated board has no effect, or the board is another:
//!
//! | test | why | on the chip |
//! |---|---|---|
//! | `parts::errors_on_the_converters_bus…` | the bus lies in the model's process, and its protocol with the host has no faults | check `check-sums` |
//! | `parts::new_firmware_is_refused…` | the chip takes firmware over its link | checks `update…` |
//! | `restarts::a_watchdog_reset…`, `restarts::the_courier_is_at_rest…` | a mailbox makes the image hang | check `hang`, `restart` |
//! | `restarts::a_stack_that_runs_over…`, `restarts::three_faults…` | a mailbox makes it spend its stack | checks `overflow`, `hang` |
//!
//! Three more can run there and are left to who names them, since they take many minutes: `demo::` and
//! `joint::both_sensors_are_calibrated…`.

use board_link::Wire;
use courier::board::{Link, Starter, chip, emulated};
use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::emulation::Operation;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::client::Client;
use courier_sensor::link::message::{
    Action, BoardStatus, CalibrateOrder, FRAME_BYTES, InForce, REPLY_CHANNEL, Reply, Source,
};
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::model::{ErrorModel, TermTable};
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::spec::CourierSpec;
use hal_sim::wire::fault::{SpiFault, Switch};
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use link_host::emulated::{Emulated, Parts};
use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

/// Time of the board's in which everything that was said has arrived.
const SHORT: Duration = Duration::from_millis(2);

/// Instants that may have passed and not be counted yet: a board without BUSY's edge counts them with the next that it serves, and its
/// main loop looks every fourth; as many again for the command's way.
const UNCOUNTED: u64 = 8;

/// A board, its surroundings, and the way to it.
pub struct Rig {
    pub link: Link,
    pub world: World,
    pub flash: SharedFlash,
    pub bus_faults: [Switch<SpiFault>; 2],
    pub hang: Rc<Cell<Option<Operation>>>,
    pub stack_spent: Rc<Cell<Option<Operation>>>,
    client: Client,
    dropped: u32,
}

impl Rig {
    /// Switched on, nothing stored.
    pub fn start(seed: u64) -> Self {
        Self::around(presets::ideal(seed), seed)
    }

    /// The same with this courier.
    pub fn around(spec: CourierSpec, seed: u64) -> Self {
        let world = World::new(spec, ControllerConfig::TYPICAL, Default::default(), seed);
        let world = world.expect("monotonic");
        let flash = SharedFlash::erased(seed);
        let parts = Parts::new(world.clone(), flash.clone());
        let (bus_faults, hang) = (parts.bus_faults.clone(), parts.hang.clone());
        let stack_spent = parts.stack_spent.clone();
        let board: Box<dyn Wire> = if on_chip() {
            Box::new(chip::start(world.clone(), flash.clone()).expect("the model runs"))
        } else {
            let images = emulated::images().expect("the images are built");
            Box::new(Emulated::start(&images, parts).expect("QEMU runs"))
        };
        Self {
            link: Link::connect(board).expect("the image answers"),
            world,
            flash,
            bus_faults,
            hang,
            stack_spent,
            client: Client::new(),
            dropped: 0,
        }
    }

    /// Switched on, a calibration with the mark 1 in force and stored.
    pub fn stored(seed: u64) -> (Self, InForce) {
        let mut rig = Self::start(seed);
        assert!(matches!(rig.store(1), Ok(Reply::Place(_))));
        let status = rig.status();
        let in_force = status.in_force;
        assert!(matches!(in_force, InForce::Stored(_)));
        // While flash was written nothing took up the queue: 25 ms of frames.
        rig.dropped = status.dropped_frames;
        assert!(rig.dropped < 600, "{}", rig.dropped);
        (rig, in_force)
    }

    /// Lets the board run.
    pub fn run(&mut self, milliseconds: u64) {
        let time = Duration::from_millis(milliseconds);
        self.link.pass(time).expect("the board runs");
    }

    pub fn status(&mut self) -> BoardStatus {
        self.link.status().expect("a status")
    }

    pub fn ask(&mut self, action: Action) -> Reply {
        self.link.ask(action).expect("a reply that is no refusal")
    }

    /// Loads and stores a calibration that corrects next to nothing, told apart by `mark`.
    pub fn store(&mut self, mark: u32) -> anyhow::Result<Reply> {
        assert_eq!(self.ask(Action::take_over(marked(mark))), Reply::Done);
        self.link.ask(Action::Commit {
            lose_unknown: false,
        })
    }

    /// The mark of the calibration in force.
    pub fn mark(&mut self) -> Option<u32> {
        match self.link.ask(Action::Read(Source::InForce)) {
            Ok(Reply::Calibration(calibration)) => Some(calibration.made.uptime_s),
            _ => None,
        }
    }

    pub fn progress(&mut self) -> Progress {
        match self.ask(Action::Progress) {
            Reply::Progress(progress) => progress,
            other => panic!("{other:?}"),
        }
    }

    /// How the session ends within so many seconds of the board's.
    pub fn ending(&mut self, seconds: u64) -> Ending {
        for _ in 0..10 * seconds {
            self.run(100);
            if let Some(ending) = self.progress().ending {
                return ending;
            }
        }
        panic!("not ended: {:?}", self.progress());
    }

    /// What the session is refused for.
    pub fn refusal(&mut self, seconds: u64) -> SessionRefusal {
        match self.ending(seconds) {
            Ending::Refused { refusal, .. } => refusal,
            other => panic!("{other:?}"),
        }
    }

    /// A request as bytes, to be sent by [`Rig::send`]; its reply is not waited for.
    pub fn request(&mut self, action: Action) -> Vec<u8> {
        let mut buffer = [0; FRAME_BYTES];
        let (_, bytes) = self.client.ask(action, &mut buffer).expect("it fits");
        bytes.to_vec()
    }

    /// Gives bytes to the board as it takes them; whatever it replies is thrown away.
    pub fn send(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let taken = self.link.wire().send(bytes).expect("the board takes bytes");
            bytes = &bytes[taken..];
            self.link.pass(SHORT).expect("the board runs");
            self.throw_replies();
        }
    }

    pub fn throw_replies(&mut self) {
        let mut bytes = [0; 4096];
        let mut take = || self.link.wire().receive(REPLY_CHANNEL, &mut bytes);
        while take().expect("the board is there") > 0 {}
    }

    /// No sampling instant was missed, and every frame was taken up but those while flash was written.
    pub fn assert_undisturbed(&mut self) {
        let status = self.status();
        assert_eq!(status.missed, 0, "sampling instants missed");
        assert_eq!(status.dropped_frames, self.dropped, "frames not taken up");
    }

    /// Every sampling instant since the start was served or counted as missed. What is true of every board: with a silent converter one
    /// serves each instant by its timer, and another one some of them, by its main loop.
    pub fn assert_every_instant_counted(&mut self) {
        let before = self.instants();
        let status = self.status();
        let counted = u64::from(status.samples) + u64::from(status.missed);
        let counts = before - UNCOUNTED..=self.instants();
        assert!(counts.contains(&counted), "{counted}, wanted {counts:?}");
    }

    /// Sampling instants since the last start, by the courier's clock.
    fn instants(&self) -> u64 {
        let [first_ns, _] = self.world.sampled_ns();
        let rate_hz = f64::from(self.link.hello().rate_hz);
        let passed_ns = self.world.clock.now_ns() - first_ns;
        1 + (passed_ns as f64 * 1e-9 * rate_hz) as u64
    }

    /// No sampling instant was missed since the start.
    pub fn assert_none_missed(&mut self) {
        assert_eq!(self.status().missed, 0, "sampling instants missed");
    }
}

/// The board that the tests run on, for a demonstration or a courier that is there already.
pub fn starter() -> Starter {
    if on_chip() {
        chip::STARTER
    } else {
        emulated::STARTER
    }
}

/// The option that names this board on a command line.
pub fn option() -> &'static str {
    if on_chip() { "--chip" } else { "--emulated" }
}

/// Whether the tests run on the model of the chip.
pub fn on_chip() -> bool {
    std::env::var_os("COURIER_TEST_BOARD").is_some_and(|board| board == "chip")
}

/// A calibration of zeros with a mark.
pub fn marked(mark: u32) -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    calibration.made.uptime_s = mark;
    calibration
}

/// The shortest session that can be accepted.
pub fn short() -> CalibrateOrder {
    CalibrateOrder {
        poses: 60,
        held_out_poses: 10,
        ..CalibrateOrder::default()
    }
}

/// A number that the environment may set: how much of something there is time for.
pub fn amount(name: &str, otherwise: u64) -> u64 {
    let told = std::env::var(name);
    told.map_or(otherwise, |text| text.parse().expect("a number"))
}
