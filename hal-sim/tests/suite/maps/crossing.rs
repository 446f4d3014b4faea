//! A map that comes in force by the board's own reference mark, without a host and without a beacon.

use super::*;
use courier_sensor::frame::Coordinate;
use courier_sensor::maps::mark::{MarkRefusal, place as place_of};
use hal_sim::world::Mark;

/// Slower than the fastest at which a mark is told.
const SPEED_M_S: f32 = 0.008;

/// An end stop that begins at this tooth along x.
fn stop(from_teeth: f64) -> Option<Mark> {
    Some(Mark {
        x_m: [from_teeth * PITCH_M, 1.0],
        y_m: [-1.0, 1.0],
    })
}

/// Starts at `home`, the stop at tooth 1.6, and goes from there along x by 2 teeth, into the stop.
fn start_into(
    home: Pose,
    beacon: Option<Pose>,
    flash: &SharedFlash,
    mark: Option<Mark>,
) -> (Bench, StoredMap) {
    let world = world(home, beacon);
    world.set_mark(mark);
    let mut bench = Bench::start(world, flash.clone());
    let before = state_after(&mut bench, 0.5);
    go(&mut bench, home, 2.0);
    (bench, before)
}

/// Goes to so many teeth beyond a place along x, and comes to rest.
fn go(bench: &mut Bench, from: Pose, teeth: f64) {
    let target = Target {
        x_m: (from.x_m + teeth * PITCH_M) as f32,
        y_m: from.y_m as f32,
        theta_rad: 0.0,
    };
    let order = Action::GoTo {
        target,
        speed_m_per_s: SPEED_M_S,
    };
    assert_eq!(bench.ask(order), Reply::Done);
    bench.run(RATE_HZ / 10);
    for _ in 0..40 {
        if !bench.status().moving {
            return;
        }
        bench.run(RATE_HZ / 10);
    }
    panic!("under way for 4 s");
}

/// Keeps the mark's place, with the map in force by its beacon.
fn learned() -> (SharedFlash, Pose) {
    let (flash, home) = (with_map(), at(0.3, -1.4));
    let (mut bench, before) = start_into(home, Some(ORIGIN), &flash, stop(1.6));
    assert!(matches!(before, StoredMap::InForce { slot: 0, .. }));
    assert_eq!(bench.ask(Action::MapKeepMark), Reply::Done);
    (flash, home)
}

const WAITS: StoredMap = StoredMap::Waits(Unusable::NoBeaconNorMark);

#[test]
fn the_mark_puts_the_map_in_force_by_itself_where_no_beacon_is() {
    let (flash, home) = learned();
    for start_teeth in [0.3, -0.2, 1.1] {
        let home = Pose {
            x_m: start_teeth * PITCH_M,
            ..home
        };
        let (mut bench, before) = start_into(home, None, &flash, stop(1.6));
        assert_eq!(before, WAITS);
        let status = bench.status();
        let StoredMap::InForce { slot: 0, ahead, .. } = status.stored_map else {
            panic!("{:?}", status.stored_map);
        };
        assert!(status.map.is_some());
        // By the platen: the map's count is 100 and -40 teeth ahead of it.
        let now = place_of([status.pose.x, status.pose.y], ahead);
        let wanted = [100.0 + start_teeth + 2.0, -41.4];
        for axis in 0..2 {
            let found = now[axis].metres(PITCH_M as f32) / PITCH_M;
            assert!((found - wanted[axis]).abs() < 0.25, "{now:?} {wanted:?}");
        }
    }
}

#[test]
fn a_mark_that_was_moved_is_refused_with_numbers_until_it_is_crossed_where_it_was() {
    let (flash, home) = learned();
    let (mut bench, before) = start_into(home, None, &flash, stop(2.0));
    assert_eq!(before, WAITS);
    let StoredMap::NotWhole { slot: 0, ahead } = bench.status().stored_map else {
        panic!("{:?}", bench.status().stored_map);
    };
    // An uncalibrated courier is off by 10 to 30 µm, which repeats with the tooth: 0.03 teeth.
    assert!((ahead[0].fraction_turns - 0.4).abs() < 0.03, "{ahead:?}");
    assert!(ahead[1].fraction_turns.abs() < 0.03, "{ahead:?}");
    assert!(bench.status().map.is_none());
    go(&mut bench, home, 0.0);
    bench.board.world.set_mark(stop(1.6));
    go(&mut bench, home, 2.0);
    assert!(matches!(
        bench.status().stored_map,
        StoredMap::InForce { slot: 0, .. }
    ));
}

#[test]
fn a_mark_is_kept_only_where_it_was_crossed_and_beside_a_map_in_force() {
    let flash = with_map();
    let home = at(0.3, -1.4);
    let (mut bench, before) = start_into(home, None, &flash, stop(1.6));
    assert_eq!(before, StoredMap::Waits(Unusable::NoBeacon));
    let refused = |bench: &mut Bench| bench.ask(Action::MapKeepMark);
    let not_in_force = MarkRefusal::NotInForce;
    assert_eq!(refused(&mut bench), Reply::Refused(not_in_force.into()));
    let (mut bench, _) = start_into(home, Some(ORIGIN), &flash, None);
    let not_crossed = MarkRefusal::NotCrossed;
    assert_eq!(refused(&mut bench), Reply::Refused(not_crossed.into()));
    // A mark that is learned anew counts from the next start on; there is room for 17.
    let world = world(home, Some(ORIGIN));
    world.set_mark(stop(1.6));
    let mut bench = Bench::start(world, flash.clone());
    state_after(&mut bench, 0.5);
    go(&mut bench, home, 2.0);
    for _ in 0..17 {
        assert_eq!(refused(&mut bench), Reply::Done);
    }
    let not_kept = MarkRefusal::NotKept;
    assert_eq!(refused(&mut bench), Reply::Refused(not_kept.into()));
    let (mut bench, _) = start_into(home, None, &flash, stop(1.6));
    assert!(matches!(
        bench.status().stored_map,
        StoredMap::InForce { .. }
    ));
}

/// Right teeth or none, wherever the courier starts and however the mark's own place scatters by a tenth of a tooth.
#[test]
fn the_teeth_are_right_in_every_try() {
    let (flash, home) = learned();
    for attempt in 0..20 {
        // Golden ratio: spread evenly, no draw needed.
        let part = |times: f64| (f64::from(attempt) * times).fract();
        let (start_teeth, miss) = (1.4 * part(0.618) - 0.2, 0.2 * part(0.755) - 0.1);
        let start = Pose {
            x_m: start_teeth * PITCH_M,
            ..home
        };
        let (mut bench, _) = start_into(start, None, &flash, stop(1.6 + miss));
        let status = bench.status();
        let StoredMap::InForce { ahead, .. } = status.stored_map else {
            panic!("{attempt}: {:?}", status.stored_map);
        };
        let now: Coordinate = place_of([status.pose.x, status.pose.y], ahead)[0];
        let off = now.metres(PITCH_M as f32) / PITCH_M - (100.0 + start_teeth + 2.0);
        assert!(off.abs() < 0.25, "{attempt}: {off}");
    }
}
