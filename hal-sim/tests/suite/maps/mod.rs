//! Tooth maps that stay, on the running board: stored over the link, in force again after each start under their beacon, and named
//! where they cannot be.

mod crossing;
mod mark;
mod rig;

use crate::bench::Bench;
use courier_sensor::device::Device;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Status;
use courier_sensor::link::message::{
    Action, InForce, MapPlace, RecordRefusal, Refusal, Reply, SlotRefusal, Source, StoredMap,
};
use courier_sensor::maps::fit::CELLS;
use courier_sensor::maps::homing::Unusable;
use courier_sensor::maps::{MapRecordError, MapSlot, MapSlotState, MapStoreError};
use courier_sensor::settings::Settings;
use effects::motion::Pose;
use hal_sim::board::SharedFlash;
use rig::*;

#[test]
fn a_map_is_in_force_within_two_seconds_of_each_start_under_its_beacon() {
    let flash = with_map();
    for home in [(0.3, -0.4), (-1.27, 2.08), (2.2, -2.2), (0.0, 1.55)] {
        let home = at(home.0, home.1);
        let mut bench = start(home, Some(ORIGIN), &flash);
        let plain = bench.board.sample().pose;
        let StoredMap::InForce {
            slot,
            ahead,
            uptime_s,
            ..
        } = state_after(&mut bench, MOST_S)
        else {
            panic!("{:?}", bench.status().stored_map)
        };
        println!("from the start to the map in force: {uptime_s:.3} s");
        assert!(slot == 0 && uptime_s <= MOST_S, "{uptime_s}");
        let status = bench.status();
        // Right teeth: what the board counts here less what the map's recording would have.
        let counted = [status.pose.x, status.pose.y].map(|place| place.metres(PITCH_M as f32));
        let here = [home.x_m + 100.0 * PITCH_M, home.y_m - 40.0 * PITCH_M];
        for axis in 0..2 {
            let wanted = ((counted[axis] - here[axis]) / PITCH_M).round() as i32;
            assert_eq!(ahead[axis].teeth, wanted);
        }
        // And it is applied: every node adds the same.
        let moved = 1.0e9 * (counted[0] - plain.x.metres(PITCH_M as f32));
        assert!((moved - f64::from(NODE_NM)).abs() < 500.0, "{moved} nm");
        assert_eq!(
            status.map.unwrap()[0].first_teeth[0],
            100 - 10 + ahead[0].teeth
        );
        assert!(matches!(status.in_force, InForce::Stored(_)));
        assert_eq!(bench.mark(), Some(1), "the calibration stays what it is");
        // The pose relative to the beacon has this start's count too.
        let frame = bench.board.sample();
        assert!(frame.beacon.seen);
        let lever_m = f64::from(Settings::default().geometry.lever_m[0]);
        assert!(
            (f64::from(frame.beacon.platen.x_m) - home.x_m - lever_m).abs() < 50.0e-6,
            "{frame:?}"
        );
        assert_eq!(status.missed + status.dropped_frames, 0);
    }
}

#[test]
fn a_map_waits_for_its_beacon_and_comes_in_force_when_the_courier_goes_there() {
    let flash = with_map();
    let mut bench = start(at(60.0, 0.0), None, &flash);
    let waits = StoredMap::Waits(Unusable::NoBeacon);
    assert_eq!(state_after(&mut bench, 1.0), waits);
    let status = bench.status();
    assert!(status.map.is_none() && matches!(status.in_force, InForce::Stored(_)));
    bench
        .board
        .world
        .with_courier(|courier| courier.set_beacon(Some(ORIGIN)));
    let target = Target {
        x_m: 0.4e-3,
        y_m: 0.0,
        theta_rad: 0.0,
    };
    let go = Action::GoTo {
        target,
        speed_m_per_s: 0.2,
    };
    assert_eq!(bench.ask(go), Reply::Done);
    assert!(matches!(
        state_after(&mut bench, 1.5),
        StoredMap::InForce { slot: 0, .. }
    ));
}

/// Two places with a beacon each: the map of the one gives way to that of the other when the courier rests there, outside the first.
#[test]
fn each_place_has_its_map_when_the_courier_goes_there() {
    let flash = with_map();
    let there = at(60.37, 0.0);
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    let mut second = place("second");
    second.anchor.beacon_m[0] = (0.37 * PITCH_M) as f32;
    assert!(matches!(
        store_at(&mut bench, second, |_| 0),
        Reply::MapSlot(MapSlot { slot: 1, .. })
    ));
    let mut in_force = |place: Pose, wanted: u8| {
        let (beacon, target) = (
            Some(place),
            Target {
                x_m: place.x_m as f32,
                y_m: 0.2e-3,
                theta_rad: 0.0,
            },
        );
        bench
            .board
            .world
            .with_courier(|courier| courier.set_beacon(beacon));
        assert_eq!(
            bench.ask(Action::GoTo {
                target,
                speed_m_per_s: 0.2
            }),
            Reply::Done
        );
        let state = state_after(&mut bench, 1.5);
        let StoredMap::InForce {
            slot,
            ahead: [x, _],
            ..
        } = state
        else {
            panic!("{state:?}")
        };
        assert_eq!(slot, wanted);
        assert!(!bench.board.sample().status.contains(Status::OUTSIDE_MAP));
        x.teeth
    };
    let first = in_force(ORIGIN, 0);
    // Both beacons are at the same whole tooth of their maps' recordings.
    assert_eq!(in_force(there, 1), first + 60);
    assert_eq!(in_force(ORIGIN, 0), first);
}

#[test]
fn a_beacon_that_was_moved_and_one_too_far_off_are_refused_with_numbers() {
    let flash = with_map();
    let mut bench = start(at(0.3, 0.0), Some(at(0.4, 0.0)), &flash);
    let StoredMap::NotWhole {
        slot: 0,
        ahead: [x, y],
    } = state_after(&mut bench, 1.0)
    else {
        panic!("{:?}", bench.status())
    };
    // The courier's own errors, which the calibration of this test leaves, turn it by up to 2 mrad at the end of the lever arm.
    assert!(
        (x.fraction_turns.abs() - 0.4).abs() < 0.05 && y.fraction_turns.abs() < 0.25,
        "{x:?} {y:?}"
    );
    let status = bench.status();
    assert!(status.map.is_none() && matches!(status.in_force, InForce::Stored(_)));
    // Put back.
    bench
        .board
        .world
        .with_courier(|courier| courier.set_beacon(Some(ORIGIN)));
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
    let mut bench = start(at(3.5, 0.0), Some(ORIGIN), &flash);
    assert_eq!(
        state_after(&mut bench, 1.0),
        StoredMap::Waits(Unusable::TooFarOff)
    );
}

#[test]
fn a_map_belongs_to_its_calibration() {
    let flash = with_map();
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
    calibrate(&mut bench, 2);
    assert_eq!(
        state_after(&mut bench, 1.0),
        StoredMap::OtherCalibration { slot: 0 }
    );
    assert!(bench.status().map.is_none());
    let Reply::Place(_) = bench.ask(Action::RollBack) else {
        panic!("nothing to go back to")
    };
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
    assert_eq!(bench.mark(), Some(1));
}

#[test]
fn another_boards_maps_are_named_and_left_alone() {
    let flash = with_map();
    let mut other = world(at(0.3, 0.0), Some(ORIGIN));
    let owner = other.number;
    other.number = Device(*b"another-one.");
    let mut bench = Bench::start(other, flash.clone());
    let device = RecordRefusal::OtherDevice(owner);
    let boot = bench.status().boot.expect("no calibration in force");
    assert!(boot.to_string().contains(&device.to_string()), "{boot}");
    assert_eq!(state_after(&mut bench, 0.5), StoredMap::None);
    let Reply::MapSlot(slot) = bench.ask(Action::MapSlot(0)) else {
        panic!("no slot")
    };
    assert_eq!(
        slot.state,
        MapSlotState::Refused(MapRecordError::OtherDevice(owner))
    );
    assert!(bench.status().map.is_none());
    // And the owner finds it as it was.
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
}

/// The map of a platen whose teeth are off by some micrometres, on one whose teeth are not.
#[test]
fn another_platen_is_told_by_the_parity_once_the_courier_moves() {
    let flash = SharedFlash::erased(39);
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    calibrate(&mut bench, 1);
    // Nodes from a fixed scramble, 10 µm either way: g_p of 6 µm or so.
    let node = |n: usize| ((n * 7919 + 13) % 20_011) as i16 - 10_005;
    assert!(matches!(
        store(&mut bench, "other", node),
        Reply::MapSlot(_)
    ));
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
    // Along x and y through more cells than are wanted, slowly.
    let target = |teeth: f64| Target {
        x_m: (teeth * PITCH_M) as f32,
        y_m: (teeth * PITCH_M) as f32,
        theta_rad: 0.0,
    };
    for teeth in [5.0, -5.0] {
        let go = Action::GoTo {
            target: target(teeth),
            speed_m_per_s: 0.03,
        };
        assert_eq!(bench.ask(go), Reply::Done);
        bench.run(RATE_HZ);
    }
    let StoredMap::OtherPlaten { slot: 0, parity } = bench.status().stored_map else {
        panic!("{:?}", bench.status())
    };
    println!("told after {} cells: {parity:?}", parity.cells);
    assert!(parity.cells == CELLS && parity.parity_m > parity.wanted_m);
    let status = bench.status();
    assert!(status.map.is_none() && matches!(status.in_force, InForce::Stored(_)));
    // It is not tried again until the board restarts.
    let go = Action::GoTo {
        target: target(0.0),
        speed_m_per_s: 0.2,
    };
    assert_eq!(bench.ask(go), Reply::Done);
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::OtherPlaten { .. }
    ));
}

#[test]
fn three_places_are_kept_a_fourth_is_refused_and_the_nearest_is_taken() {
    let flash = with_map();
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    for name in ["second", "third"] {
        assert!(matches!(store(&mut bench, name, |_| 0), Reply::MapSlot(_)));
    }
    let full = Reply::Refused(Refusal::MapStore(MapStoreError::Full));
    assert_eq!(store(&mut bench, "fourth", |_| 0), full);
    // Of its own place a map is replaced, and what is in force stays a stored calibration.
    assert!(matches!(
        store(&mut bench, "second", |_| 0),
        Reply::MapSlot(MapSlot { slot: 3, .. })
    ));
    assert!(matches!(bench.in_force(), InForce::Stored(_)));
    assert_eq!(bench.ask(Action::MapForget(2)), Reply::Done);
    assert!(matches!(
        store(&mut bench, "fourth", |_| 0),
        Reply::MapSlot(_)
    ));
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
}

#[test]
fn an_order_to_drop_the_map_holds_until_the_restart() {
    let flash = with_map();
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
    assert_eq!(bench.ask(Action::MapDrop), Reply::Done);
    assert_eq!(state_after(&mut bench, 1.0), StoredMap::Ordered);
    assert!(bench.status().map.is_none());
    let calibration = match bench.ask(Action::Read(Source::InForce)) {
        Reply::Calibration(calibration) => calibration,
        other => panic!("{other:?}"),
    };
    assert_eq!(
        calibration.model,
        bench
            .board
            .background
            .keeper()
            .settings()
            .model
            .clone()
            .unwrap()
    );
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    assert!(matches!(
        state_after(&mut bench, 1.0),
        StoredMap::InForce { .. }
    ));
}

/// Nodes without a beginning, an end without all nodes, no stored calibration: named, and what was in force still is.
#[test]
fn a_map_that_is_stored_by_half_is_refused() {
    let flash = SharedFlash::erased(40);
    let mut bench = start(at(0.3, 0.0), Some(ORIGIN), &flash);
    let none = Reply::Refused(Refusal::Slots(SlotRefusal::NoneInForce));
    assert_eq!(store(&mut bench, "a", |_| 0), none);
    calibrate(&mut bench, 1);
    let nodes =
        |found, wanted| Reply::Refused(Refusal::MapStore(MapStoreError::Nodes { found, wanted }));
    assert_eq!(bench.ask(Action::MapStoreEnd), nodes(0, 0));
    let begin = Action::MapStore {
        place: place("a"),
        header: header(),
    };
    assert_eq!(bench.ask(begin.clone()), Reply::Done);
    assert_eq!(bench.ask(Action::MapStoreEnd), nodes(0, 800));
    assert_eq!(bench.ask(begin), Reply::Done);
    let many = || Action::MapStoreNodes([0; 200].into_iter().collect());
    (0..4).for_each(|_| assert_eq!(bench.ask(many()), Reply::Done));
    assert_eq!(bench.ask(many()), nodes(1000, 800));
    let place = MapPlace {
        parity_m: f32::NAN,
        ..place("a")
    };
    let refused = bench.ask(Action::MapStore {
        place,
        header: header(),
    });
    assert!(
        matches!(
            refused,
            Reply::Refused(Refusal::MapStore(MapStoreError::Record { .. }))
        ),
        "{refused:?}"
    );
    assert_eq!(state_after(&mut bench, 0.5), StoredMap::None);
    assert_eq!(bench.mark(), Some(1));
}
