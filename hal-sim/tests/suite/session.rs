//! The firmware on the simulated board, driven over its debug link as a host would: from power-up without a calibration
//! to an accepted one that survives a restart, and what must not happen when something is in the way.

use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::calibration::record::Method;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Status;
use courier_sensor::link::client::Client;
use courier_sensor::link::message::{
    Action, CalibrateOrder, FRAME_BYTES, InForce, Refusal, Reply, Source, StartRefusal,
};
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::settings::Settings;
use courier_sensor::update::install::UpdateRefusal;
use courier_sensor::update::order::UpdateOrder;
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::presets;
use hal_sim::wire::motion::{ControllerConfig, Misbehaviour};
use hal_sim::world::World;

/// A board and the host's end of its link.
struct Bench {
    board: SimBoard,
    client: Client,
}

impl Bench {
    fn start(world: World, flash: SharedFlash) -> Self {
        let board = SimBoard::start(world, flash, Settings::default()).expect("the board starts");
        let mut bench = Self {
            board,
            client: Client::new(),
        };
        let mut buffer = [0; FRAME_BYTES];
        let (_, bytes) = bench.client.hello(&mut buffer).expect("a hello fits");
        assert_eq!(bench.board.link.write_commands(bytes), bytes.len());
        assert!(matches!(bench.reply(), Reply::Hello(_)));
        bench
    }

    fn ask(&mut self, action: Action) -> Reply {
        let mut buffer = [0; FRAME_BYTES];
        let (_, mut bytes) = self.client.ask(action, &mut buffer).expect("a frame fits");
        while !bytes.is_empty() {
            let taken = self.board.link.write_commands(bytes);
            bytes = &bytes[taken..];
            self.board.sample();
        }
        self.reply()
    }

    fn reply(&mut self) -> Reply {
        for _ in 0..1000 {
            self.board.sample();
            let mut bytes = [0; 4096];
            let taken = self.board.link.read_replies(&mut bytes);
            for byte in &bytes[..taken] {
                if let Some(response) = self.client.feed(*byte) {
                    return response.reply;
                }
            }
        }
        panic!("no reply within 1000 samples");
    }

    fn progress(&mut self) -> Progress {
        match self.ask(Action::Progress) {
            Reply::Progress(progress) => progress,
            other => panic!("{other:?}"),
        }
    }

    fn ending(&mut self, samples: u32) -> Ending {
        for _ in 0..samples / 2000 {
            (0..2000).for_each(|_| {
                self.board.sample();
            });
            if let Some(ending) = self.progress().ending {
                return ending;
            }
        }
        panic!("not ended: {:?}", self.progress());
    }
}

fn world(seed: u64) -> World {
    let spec = presets::ideal(seed);
    World::new(spec, ControllerConfig::TYPICAL, Default::default(), seed).expect("monotonic")
}

fn short() -> CalibrateOrder {
    CalibrateOrder {
        poses: 100,
        held_out_poses: 40,
        ..CalibrateOrder::default()
    }
}

#[test]
fn calibrates_stores_and_starts_from_it() {
    let flash = SharedFlash::erased(1);
    let mut bench = Bench::start(world(3), flash.clone());
    assert!(bench.board.sample().status.contains(Status::UNCALIBRATED));
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    assert_eq!(
        bench.ask(Action::Calibrate(short())),
        Reply::Refused(Refusal::Busy)
    );
    let ending = bench.ending(2_000_000);
    let Ending::Accepted {
        evidence,
        stored: Some(place),
    } = ending
    else {
        panic!("{ending:?}")
    };
    assert!(
        evidence.held_out_m < 0.1 * evidence.held_out_raw_m,
        "{evidence:?}"
    );
    let Reply::Calibration(stored) = bench.ask(Action::Read(Source::InForce)) else {
        panic!("no calibration")
    };
    let mut bench = Bench::start(bench.board.stop(), flash);
    assert!(!bench.board.sample().status.contains(Status::UNCALIBRATED));
    let Reply::Status(status) = bench.ask(Action::Status) else {
        panic!("no status")
    };
    assert_eq!(status.in_force, InForce::Stored(place));
    assert_eq!(
        bench.ask(Action::Read(Source::InForce)),
        Reply::Calibration(stored)
    );
}

#[test]
fn a_controller_that_never_settles_is_named_and_nothing_changes() {
    let flash = SharedFlash::erased(2);
    let mut bench = Bench::start(world(4), flash.clone());
    bench
        .board
        .world
        .motion
        .misbehave(Misbehaviour::NeverSettles);
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    let ending = bench.ending(200_000);
    let Ending::Refused {
        refusal: SessionRefusal::NotSettled { waited, limit, .. },
        ..
    } = ending
    else {
        panic!("{ending:?}")
    };
    assert!(waited > limit);
    let Reply::Status(status) = bench.ask(Action::Status) else {
        panic!("no status")
    };
    assert_eq!(status.in_force, InForce::None);
}

#[test]
fn abort_ends_the_motion_and_keeps_what_is_in_force() {
    let mut bench = Bench::start(world(5), SharedFlash::erased(3));
    assert_eq!(
        bench.ask(Action::Abort),
        Reply::Refused(Refusal::NothingUnderWay)
    );
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    (0..20_000).for_each(|_| {
        bench.board.sample();
    });
    assert_eq!(bench.ask(Action::Abort), Reply::Done);
    let ending = bench.ending(100_000);
    assert!(
        matches!(
            ending,
            Ending::Refused {
                refusal: SessionRefusal::Aborted,
                ..
            }
        ),
        "{ending:?}"
    );
}

#[test]
fn moves_where_it_is_told() {
    let mut bench = Bench::start(world(6), SharedFlash::erased(4));
    let target = Target {
        x_m: 2.0e-3,
        y_m: -1.0e-3,
        theta_rad: 0.004,
    };
    let order = Action::GoTo {
        target,
        speed_m_per_s: 0.1,
    };
    assert_eq!(bench.ask(order), Reply::Done);
    for _ in 0..20_000 {
        bench.board.sample();
    }
    let Reply::Status(status) = bench.ask(Action::Status) else {
        panic!("no status")
    };
    assert!(!status.moving);
    let truth = bench.board.world.truth().pose;
    // Open loop: the controller of this simulation ends some 30 um and 0.2 mrad off.
    assert!((truth.x_m - 2.0e-3).abs() < 2.0e-4, "{truth:?}");
    assert!((truth.y_m + 1.0e-3).abs() < 2.0e-4, "{truth:?}");
    assert!((truth.theta_rad - 0.004).abs() < 1.5e-3, "{truth:?}");
}

#[test]
fn calibrates_both_sensors_under_the_beacon() {
    let mut spec = presets::ideal(7);
    // The drawing is 5 % off.
    spec.geometry.height_m *= 1.05;
    spec.geometry.lever_m[0] *= 0.95;
    spec.geometry.lever_m[1] *= 1.05;
    let truth = spec.geometry;
    let world =
        World::new(spec, ControllerConfig::TYPICAL, Default::default(), 7).expect("monotonic");
    let flash = SharedFlash::erased(5);
    let mut bench = Bench::start(world, flash.clone());
    let order = CalibrateOrder {
        method: Method::Joint,
        poses: 300,
        held_out_poses: 60,
        travel_m: 2.032e-3,
        turn_rad: 0.02618,
        ..CalibrateOrder::default()
    };
    assert_eq!(bench.ask(Action::Calibrate(order)), Reply::Done);
    let ending = bench.ending(4_000_000);
    let progress = bench.progress();
    assert!(
        matches!(
            ending,
            Ending::Accepted {
                stored: Some(_),
                ..
            }
        ),
        "{ending:?} {:?}",
        progress.steps
    );
    let Reply::Calibration(found) = bench.ask(Action::Read(Source::InForce)) else {
        panic!("no calibration")
    };
    assert_eq!(found.method, Method::Joint);
    // 300 poses at a twentieth of the paper's noise: the synthetic problem's 20 um, with room.
    let errors = [
        f64::from(found.geometry.height_m) - truth.height_m,
        f64::from(found.geometry.lever_m[0]) - truth.lever_m[0],
        f64::from(found.geometry.lever_m[1]) - truth.lever_m[1],
    ];
    assert!(errors.iter().all(|e| e.abs() < 20.0e-6), "{errors:?}");
    // The beacon is switched off: a joint calibration is refused by name, and what is in force stays.
    bench
        .board
        .world
        .with_courier(|courier| courier.set_beacon(None));
    (0..100).for_each(|_| {
        bench.board.sample();
    });
    assert_eq!(
        bench.ask(Action::Calibrate(order)),
        Reply::Refused(Refusal::Start(StartRefusal::NoBeacon))
    );
}

/// A board without a first stage: SimBoard::start gives it no image.
#[test]
fn a_board_without_a_first_stage_refuses_new_firmware_in_one_line() {
    let mut bench = Bench::start(world(1), SharedFlash::erased(1));
    let begin = UpdateOrder::Begin {
        header: Default::default(),
        allow_older: false,
    };
    for order in [UpdateOrder::Status, begin, UpdateOrder::Accept] {
        let refused = Reply::Refused(Refusal::Update(UpdateRefusal::NotOffered));
        assert_eq!(bench.ask(Action::Update(order)), refused);
    }
    let told = UpdateRefusal::NotOffered.to_string();
    assert!(told.contains("takes no firmware over its link") && !told.contains('\n'));
}
