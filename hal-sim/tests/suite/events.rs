//! The board's story in its flash: what is written, when, and how often.

use crate::bench::{Bench, short, world};
use courier_sensor::app::restarts::SERVICE_S;
use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::slots::Place;
use courier_sensor::event_log::entry::{Ending, Event};
use courier_sensor::event_log::pace::{MOST_SHORT_STARTS, START_S};
use courier_sensor::frame::Status;
use courier_sensor::link::message::{Action, InForce, Reply, ResetCause};
use courier_sensor::settings::Settings;
use courier_sensor::update::layout::{LOG_END, LOG_START};
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::wire::fault::{InputFault, When};

const RATE_HZ: u32 = 20_000;
/// Time within which an event is written, samples: two looks.
const SOON: u32 = RATE_HZ / 5;

fn stored(slot: u8, sequence: u32) -> InForce {
    InForce::Stored(Place { slot, sequence })
}

fn started(cause: ResetCause, in_force: InForce) -> impl Fn(&Event) -> bool {
    move |event| matches!(event, Event::Started { cause: found, in_force: now, fault: None, .. } if *found == cause && *now == in_force)
}

/// A board that starts for this cause.
fn start(cause: ResetCause, flash: &SharedFlash) -> Bench {
    let board = SimBoard::start_image(cause, world(7), flash.clone(), Settings::default(), None);
    let mut bench = Bench {
        board: board.expect("it starts"),
        client: courier_sensor::link::client::Client::new(),
    };
    bench.hello();
    bench
}

#[test]
fn a_board_keeps_its_story_over_restarts() {
    let flash = SharedFlash::erased(39);
    let mut bench = start(ResetCause::PowerOn, &flash);
    assert_eq!(bench.story(), []);
    bench.run(START_S * RATE_HZ + SOON);
    let unix_s = 1_800_000_000;
    assert_eq!(bench.ask(Action::SetTime { unix_s }), Reply::Done);
    bench.store(1);
    bench.run(SOON);
    bench.store(2);
    bench.run(SOON);
    bench.ask(Action::RollBack);
    bench.run(SOON);
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    bench.run(SOON);
    assert_eq!(bench.ask(Action::Abort), Reply::Done);
    bench.run(SOON);
    let mut bench = start(ResetCause::BrownOut, &flash);
    bench.run(START_S * RATE_HZ + SOON);
    let story = bench.story();
    let heads: Vec<_> = story.iter().map(|(head, _)| *head).collect();
    let numbers: Vec<u32> = heads.iter().map(|head| head.number).collect();
    assert_eq!(numbers, (1..=heads.len() as u32).collect::<Vec<_>>());
    let told: Vec<Event> = story.into_iter().map(|(_, event)| event).collect();
    let wanted = [
        Event::InForce {
            now: stored(0, 1),
            rolled_back: false,
        },
        Event::InForce {
            now: stored(1, 2),
            rolled_back: false,
        },
        Event::InForce {
            now: stored(0, 1),
            rolled_back: true,
        },
        Event::CalibrationBegun(Method::Platen),
        Event::CalibrationEnded {
            ending: Ending::Refused(SessionRefusal::Aborted),
            held_out_m: [0.0; 2],
        },
    ];
    let (first, rest) = told.split_first().unwrap();
    assert!(
        started(ResetCause::PowerOn, InForce::None)(first),
        "{first:?}"
    );
    let (last, between) = rest.split_last().unwrap();
    assert_eq!(between, wanted);
    assert!(
        started(ResetCause::BrownOut, stored(0, 1))(last),
        "{last:?}"
    );
    assert_eq!([heads[0].start, heads[6].start], [1, 2]);
    assert_eq!(heads[0].time.unix_s, None);
    let date = heads[1].time.unix_s.expect("it was told");
    assert!((unix_s..unix_s + 2).contains(&date));
    assert_eq!(heads[6].time.uptime_s, START_S);
}

#[test]
fn a_fault_of_the_sensor_is_told_once_a_start() {
    let flash = SharedFlash::erased(40);
    let mut bench = start(ResetCause::PowerOn, &flash);
    bench.run(START_S * RATE_HZ + SOON);
    for _ in 0..5 {
        let fault = bench.board.world.converter.input_fault();
        fault.set(InputFault::Frozen, When::Always);
        bench.run(SOON);
        fault.clear();
        bench.run(SOON);
    }
    let events = bench.story().into_iter().map(|(_, event)| event);
    let status: Vec<Event> = events
        .filter(|event| matches!(event, Event::Status(_)))
        .collect();
    assert!(status.len() == 1, "{status:?}");
    assert!(
        matches!(status[0], Event::Status(bits) if Status::from_bits_truncate(bits).contains(Status::FROZEN))
    );
}

#[test]
fn a_supply_that_flickers_wears_no_flash() {
    let flash = SharedFlash::erased(41);
    for _ in 0..2 * MOST_SHORT_STARTS {
        let mut bench = start(ResetCause::BrownOut, &flash);
        bench.run(START_S * RATE_HZ + SOON);
    }
    let mut bench = start(ResetCause::BrownOut, &flash);
    assert_eq!(bench.story().len() as u32, MOST_SHORT_STARTS);
    bench.run(SERVICE_S * RATE_HZ);
    assert_eq!(
        bench.story().len() as u32,
        MOST_SHORT_STARTS,
        "it has not lasted"
    );
}

#[test]
fn a_flash_that_takes_nothing_stops_nothing() {
    let flash = SharedFlash::erased(42);
    // Pages that do not erase and are full of what is no log.
    flash.0.borrow_mut().force(
        LOG_START as usize,
        &vec![0x5A; (LOG_END - LOG_START) as usize],
    );
    flash.0.borrow_mut().wear_out();
    let mut bench = start(ResetCause::PowerOn, &flash);
    bench.run(START_S * RATE_HZ + SOON);
    let status = bench.status();
    assert_eq!(status.missed, 0);
    let Reply::KeptLog(page) = bench.ask(Action::KeptLog { skip: 0 }) else {
        panic!("no log");
    };
    assert_eq!(page.entries().count(), 0);
    let marks = 4 * 16;
    assert_eq!(u32::from(page.damaged_bytes), LOG_END - LOG_START - marks);
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
}
