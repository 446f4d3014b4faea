//! A map that comes in force by a reference mark, where no beacon is.

use super::*;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Coordinate;
use courier_sensor::maps::homing::MOST_LEFT_TURNS;
use courier_sensor::maps::mark::{self, MarkRefusal};

/// The mark of these tests, where the courier of another start learned it: a place in the map's count.
fn learned(flash: &SharedFlash, home: Pose) -> [Coordinate; 2] {
    let mut bench = start(home, Some(ORIGIN), flash);
    let StoredMap::InForce { ahead, .. } = state_after(&mut bench, MOST_S) else {
        panic!("no map in force");
    };
    let pose = bench.status().pose;
    mark::place([pose.x, pose.y], ahead)
}

#[test]
fn a_mark_puts_the_map_in_force_where_no_beacon_is() {
    let flash = with_map();
    let home = at(2.3, -1.4);
    let mark = learned(&flash, home);
    // By the platen: the map's count is 100 and -40 teeth ahead of it. What decides is a quarter of a tooth.
    let wanted = [102.3, -41.4];
    for axis in 0..2 {
        let found = mark[axis].metres(PITCH_M as f32) / PITCH_M;
        assert!(
            (found - wanted[axis]).abs() < f64::from(MOST_LEFT_TURNS),
            "{mark:?}"
        );
    }
    // A controller finds its mark within a tenth of a tooth, as a prior has it.
    for miss_teeth in [0.0, 0.1, -0.1] {
        let there = Pose {
            x_m: home.x_m + miss_teeth * PITCH_M,
            ..home
        };
        let mut bench = start(there, None, &flash);
        let waits = StoredMap::Waits(Unusable::NoBeacon);
        assert_eq!(state_after(&mut bench, 0.5), waits);
        assert_eq!(bench.ask(Action::MapAtMark { slot: 0, mark }), Reply::Done);
        bench.run(10);
        let status = bench.status();
        let StoredMap::InForce { slot: 0, ahead, .. } = status.stored_map else {
            panic!("{:?}", status.stored_map);
        };
        let place = mark::place([status.pose.x, status.pose.y], ahead);
        for axis in 0..2 {
            assert_eq!(
                place[axis].minus_turns(mark[axis]).round(),
                0.0,
                "{place:?} {mark:?}"
            );
        }
        assert!(status.map.is_some());
        let again = bench.ask(Action::MapAtMark { slot: 0, mark });
        assert_eq!(again, Reply::Refused(MarkRefusal::InForce.into()));
    }
}

#[test]
fn a_mark_that_leaves_more_than_a_quarter_of_a_tooth_is_refused_with_numbers() {
    let flash = with_map();
    let home = at(2.3, -1.4);
    let mark = learned(&flash, home);
    let beside = Pose {
        y_m: home.y_m + 0.4 * PITCH_M,
        ..home
    };
    let mut bench = start(beside, None, &flash);
    bench.run(2000);
    let at_mark = |slot| Action::MapAtMark { slot, mark };
    let Reply::Refused(Refusal::Mark(refusal @ MarkRefusal::NotWhole { ahead })) =
        bench.ask(at_mark(0))
    else {
        panic!("not refused");
    };
    assert!(
        (ahead[0].fraction_turns.abs() - 0.0).abs() < 0.01,
        "{ahead:?}"
    );
    assert!((ahead[1].fraction_turns - 0.4).abs() < 0.01, "{ahead:?}");
    let words = refusal.to_string();
    assert!(
        words.contains("wanted whole numbers within 0.25"),
        "{words}"
    );
    assert_eq!(
        bench.ask(at_mark(1)),
        Reply::Refused(MarkRefusal::NoMap(1).into())
    );
    assert!(bench.status().map.is_none());
    // While the courier moves it is at no mark.
    let target = Target {
        x_m: 0.02,
        ..Target::default()
    };
    let go = Action::GoTo {
        target,
        speed_m_per_s: 0.2,
    };
    assert_eq!(bench.ask(go), Reply::Done);
    bench.run(1000);
    let too_fast = MarkRefusal::Unusable(Unusable::TooFast);
    assert_eq!(bench.ask(at_mark(0)), Reply::Refused(too_fast.into()));
    // Another calibration than the map's.
    let mut bench = start(home, None, &flash);
    calibrate(&mut bench, 2);
    bench.run(10);
    let other = MarkRefusal::OtherCalibration(0);
    assert_eq!(bench.ask(at_mark(0)), Reply::Refused(other.into()));
}
