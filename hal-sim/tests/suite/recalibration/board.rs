//! The recalibration on the simulated board: at the full rate, through the firmware's own signal path, by orders over the link.

use crate::bench::Bench;
use crate::watch::board::{CHANGE_S, calibrated_board, work};
use courier_sensor::calibration::recalibration::{Idle, Mode, Order, State};
use courier_sensor::event_log::entry::Event;
use courier_sensor::link::message::{Action, BoardStatus, InForce, Refusal, Reply, Source};
use effects::random::{ChaCha8Rng, SeedableRng};

/// The change, by the time it is seen, and as many windows as tell it.
const UNTIL_S: u32 = CHANGE_S as u32 + 240;

fn order(bench: &mut Bench, order: Order) -> Reply {
    let reply = bench.ask(Action::Recalibrate(order));
    bench.run(50);
    reply
}

fn state(bench: &mut Bench) -> State {
    bench.status().recalibration.state
}

/// Segment 2's order 2 in force, metres: sine.
fn wave_m(bench: &mut Bench) -> f32 {
    let Reply::Calibration(calibration) = bench.ask(Action::Read(Source::InForce)) else {
        panic!("wanted the calibration in force")
    };
    calibration.model.coefficients[1][1][0]
}

fn slot(status: &BoardStatus) -> u8 {
    match status.in_force {
        InForce::Stored(place) => place.slot,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_candidate_is_proposed_rejected_and_comes_in_force_by_itself_when_that_is_allowed() {
    let (mut bench, flash) = calibrated_board();
    assert_eq!(state(&mut bench), State::Idle(Idle::NotStored));
    let commit = Action::Commit {
        lose_unknown: false,
    };
    assert!(matches!(bench.ask(commit), Reply::Place(_)));
    assert_eq!(state(&mut bench), State::Idle(Idle::NoReference));
    let none = Reply::Refused(Refusal::NoCandidate);
    assert_eq!(order(&mut bench, Order::Accept), none);
    assert_eq!(order(&mut bench, Order::Reject), none);
    let before_m = wave_m(&mut bench);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let proposed = |status: &BoardStatus| matches!(status.recalibration.state, State::Proposed(_));
    assert!(work(&mut bench, &mut rng, UNTIL_S, proposed));
    let State::Proposed(candidate) = state(&mut bench) else {
        panic!("proposed a moment ago")
    };
    assert_eq!((candidate.segment, candidate.order), (1, 2));
    assert_eq!(wave_m(&mut bench), before_m, "a proposal changes nothing");
    assert_eq!(order(&mut bench, Order::Reject), Reply::Done);
    assert_eq!(state(&mut bench), State::Idle(Idle::Rejected));
    assert_eq!(order(&mut bench, Order::Accept), none);
    // By order it is looked for again, and comes in force by itself; the amplitude is 1.41 µm.
    assert_eq!(order(&mut bench, Order::Set(Mode::Automatic)), Reply::Done);
    let slot_before = slot(&bench.status());
    let adopted = |status: &BoardStatus| status.recalibration.adopted > 0;
    let until_s = bench.status().time.uptime_s + 240;
    assert!(work(&mut bench, &mut rng, until_s, adopted));
    let amended_m = before_m - wave_m(&mut bench);
    assert!((0.5e-6..2.0e-6).contains(&amended_m), "{amended_m:e}");
    let status = bench.status();
    assert_eq!(slot(&status), 1 - slot_before);
    // Half a second: the log looks ten times in one, and says both.
    bench.run(10_000);
    let story: Vec<Event> = bench.story().into_iter().map(|(_, event)| event).collect();
    let is_proposed =
        |event: &Event| matches!(event, Event::Proposed(of) if (of.segment, of.order) == (1, 2));
    assert!(story.iter().any(is_proposed), "{story:?}");
    let recalibrated = Event::Recalibrated(status.in_force);
    assert!(story.contains(&recalibrated), "{story:?}");
    // The one before is one rollback away, and the mode outlives it and a restart.
    assert!(
        matches!(bench.ask(Action::RollBack), Reply::Place(place) if place.slot == slot_before)
    );
    bench.run(50);
    assert_eq!(wave_m(&mut bench), before_m);
    let mut bench = Bench::start(bench.board.stop(), flash);
    bench.run(50);
    assert_eq!(bench.status().recalibration.mode, Mode::Automatic);
    assert_eq!(wave_m(&mut bench), before_m);
    assert_eq!(order(&mut bench, Order::Set(Mode::Off)), Reply::Done);
    assert_eq!(state(&mut bench), State::Idle(Idle::Off));
}
