//! A simulated board and the host's end of its debug link, for tests.
#![allow(dead_code)] // each test program uses a part

use courier_sensor::event_log::entry::{Event, Head, Read, decode};
use courier_sensor::link::client::Client;
use courier_sensor::link::message::{
    Action, BoardStatus, CalibrateOrder, FRAME_BYTES, InForce, Reply, Source,
};
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::settings::Settings;
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// A board and a host that has said hello.
pub struct Bench {
    pub board: SimBoard,
    pub client: Client,
}

impl Bench {
    pub fn start(world: World, flash: SharedFlash) -> Self {
        Self::start_with(world, flash, Settings::default())
    }

    pub fn start_with(world: World, flash: SharedFlash, settings: Settings) -> Self {
        let board = SimBoard::start(world, flash, settings).expect("the board starts");
        let mut bench = Self {
            board,
            client: Client::new(),
        };
        bench.hello();
        bench
    }

    pub fn hello(&mut self) {
        let mut buffer = [0; FRAME_BYTES];
        let (_, bytes) = self.client.hello(&mut buffer).expect("a hello fits");
        let bytes = bytes.to_vec();
        self.send(&bytes);
        assert!(matches!(self.reply(), Reply::Hello(_)));
    }

    /// Gives bytes to the board as it takes them.
    pub fn send(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let taken = self.board.link.write_commands(bytes);
            bytes = &bytes[taken..];
            self.board.sample();
        }
    }

    pub fn request(&mut self, action: Action) -> Vec<u8> {
        let mut buffer = [0; FRAME_BYTES];
        self.client
            .ask(action, &mut buffer)
            .expect("a request fits")
            .1
            .to_vec()
    }

    pub fn ask(&mut self, action: Action) -> Reply {
        let bytes = self.request(action);
        self.send(&bytes);
        self.reply()
    }

    pub fn reply(&mut self) -> Reply {
        for _ in 0..1000 {
            self.board.sample();
            if let Some(reply) = self.take_reply() {
                return reply;
            }
        }
        panic!("no reply within 1000 samples");
    }

    /// A reply that has come.
    pub fn take_reply(&mut self) -> Option<Reply> {
        let mut byte = [0];
        while self.board.link.read_replies(&mut byte) > 0 {
            if let Some(response) = self.client.feed(byte[0]) {
                return Some(response.reply);
            }
        }
        None
    }

    pub fn run(&mut self, samples: u32) {
        (0..samples).for_each(|_| {
            self.board.sample();
        });
    }

    pub fn status(&mut self) -> BoardStatus {
        match self.ask(Action::Status) {
            Reply::Status(status) => status,
            other => panic!("{other:?}"),
        }
    }

    pub fn in_force(&mut self) -> InForce {
        self.status().in_force
    }

    pub fn progress(&mut self) -> Progress {
        match self.ask(Action::Progress) {
            Reply::Progress(progress) => progress,
            other => panic!("{other:?}"),
        }
    }

    /// What the board has kept of its story.
    pub fn story(&mut self) -> Vec<(Head, Event)> {
        let mut story = Vec::new();
        loop {
            let skip = story.len() as u16;
            let Reply::KeptLog(page) = self.ask(Action::KeptLog { skip }) else {
                panic!("no log");
            };
            story.extend(page.entries().map(|entry| match decode(entry) {
                Some(Read::Known(head, event)) => (head, event),
                other => panic!("{other:?}"),
            }));
            assert_eq!(page.damaged_bytes, 0);
            if !page.more {
                return story;
            }
        }
    }

    /// How the session ends, within so many samples.
    pub fn ending(&mut self, samples: u32) -> Ending {
        for _ in 0..samples / 2000 {
            self.run(2000);
            if let Some(ending) = self.progress().ending {
                return ending;
            }
        }
        panic!("not ended: {:?}", self.progress());
    }

    /// Loads and stores a calibration that corrects next to nothing, told apart by `mark`.
    pub fn store(&mut self, mark: u32) -> Reply {
        assert_eq!(self.ask(Action::take_over(marked(mark))), Reply::Done);
        self.run(2);
        self.ask(Action::Commit {
            lose_unknown: false,
        })
    }

    /// The mark of the calibration in force.
    pub fn mark(&mut self) -> Option<u32> {
        match self.ask(Action::Read(Source::InForce)) {
            Reply::Calibration(calibration) => Some(calibration.made.uptime_s),
            _ => None,
        }
    }
}

/// A calibration of zeros with a mark.
pub fn marked(mark: u32) -> courier_sensor::calibration::record::Calibration {
    use courier_sensor::model::{ErrorModel, TermTable};
    let geometry = courier_sensor::geometry::Geometry::PAPER;
    let mut calibration = courier_sensor::calibration::record::Calibration::identity(geometry);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    calibration.made.uptime_s = mark;
    calibration
}

pub fn world(seed: u64) -> World {
    let spec = presets::ideal(seed);
    World::new(spec, ControllerConfig::TYPICAL, Default::default(), seed).expect("monotonic")
}

/// The shortest session there is to order.
pub fn short() -> CalibrateOrder {
    CalibrateOrder {
        poses: 60,
        held_out_poses: 10,
        ..CalibrateOrder::default()
    }
}
