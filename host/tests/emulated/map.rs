//! A tooth map as large as there is room for, in force on the image: the interrupt takes its time, and the background keeps its own.

use crate::rig::Rig;
use courier::board::map;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Coordinate, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, MapPlace, Reply, StoredMap};
use courier_sensor::link::telemetry::Channels;
use courier_sensor::maps::homing::{Anchor, Unusable};
use courier_sensor::maps::mark;
use courier_sensor::teeth::{Grid, MAX_NODES, MapHeader, TRUST_WORDS, Wave};
use hal_sim::world::Mark;
use std::time::Duration;

/// Waves of `courier map`.
const WAVES: [(u8, i8); 6] = [(0, 1), (0, 2), (1, 1), (1, -1), (2, 1), (2, -1)];
/// A reply comes within so much of the board's time, with a map as without: it asks for one status.
const LATEST_REPLY: Duration = Duration::from_millis(20);

/// About tooth count zero, every cell trusted, of micrometres.
fn largest() -> (MapHeader, Vec<i16>) {
    let grid = Grid {
        first_teeth: [-10, -10],
        nodes: [20, 20],
    };
    let wave = |(own_order, lateral_order)| Wave {
        own_order,
        lateral_order,
        coefficients_m: [[1.0e-6, -2.0e-6]; 4],
    };
    let header = MapHeader {
        grids: [grid; 2],
        waves: WAVES.into_iter().map(wave).collect(),
        trusted: [u32::MAX; TRUST_WORDS].into_iter().collect(),
    };
    let node = |n: usize| (n * 37 % 401) as i16 - 200;
    (header, (0..MAX_NODES).map(node).collect())
}

/// Looks at the board for each rate of streaming, 10 ms of its time apart: 0.3 s in all, where the ring of the stream holds 12 ms.
const LOOKS: u32 = 30;
/// Frames of that time, at 20 kHz.
const FRAMES: u32 = LOOKS * 200;

/// Streams one sample in so many for a while: frames that the background did not take up, and the latest reply.
fn streamed(rig: &mut Rig, decimation: u16) -> (u32, Duration) {
    let channels = Channels::STATUS | Channels::CALIBRATED;
    rig.link.stream(channels, decimation).expect("a stream");
    let (dropped, mut latest) = (rig.status().dropped_frames, Duration::ZERO);
    for _ in 0..LOOKS {
        rig.run(10);
        rig.link.listen(|_| Ok(())).expect("the board is there");
        let asked_ns = rig.world.clock.now_ns();
        let status = rig.status();
        latest = latest.max(Duration::from_nanos(rig.world.clock.now_ns() - asked_ns));
        let outside = status.status & Status::OUTSIDE_MAP.bits();
        assert_eq!(outside, 0, "{status:?}");
    }
    rig.link.stream(Channels::empty(), 0).expect("its end");
    (rig.status().dropped_frames - dropped, latest)
}

/// Asked: from the restart to the map in force, under its beacon.
const MOST_S: f32 = 2.0;

/// About tooth count zero, where the courier stands at its start, under its beacon.
fn place() -> MapPlace {
    let geometry = Geometry::PAPER;
    MapPlace {
        name: "origin".try_into().expect("short"),
        anchor: Anchor {
            beacon_teeth: [0; 2],
            beacon_m: [0.0; 2],
            height_m: geometry.height_m,
            lever_m: geometry.lever_m,
        },
        parity_m: 1.0e-6,
    }
}

/// Seconds from the board's start to the stored map in force.
fn placed_s(rig: &mut Rig) -> f32 {
    for _ in 0..20 {
        rig.run(50);
        if let StoredMap::InForce { uptime_s, .. } = rig.status().stored_map {
            return uptime_s;
        }
    }
    panic!("{:?}", rig.status().stored_map)
}

#[test]
fn the_largest_map_is_in_force_soon_after_a_restart_and_outlasts_a_power_cut() {
    let (mut rig, _) = Rig::stored(32);
    let (header, nodes) = largest();
    let before = rig.flash.0.borrow().steps();
    let stored = map::store_map(&mut rig.link, place(), header.clone(), &nodes);
    assert_eq!(stored.expect("it is stored").slot, 0);
    let steps = rig.flash.0.borrow().steps() - before;
    placed_s(&mut rig);
    assert_eq!(rig.status().missed, 0);
    rig.link.restart().expect("the board restarts");
    let seconds = placed_s(&mut rig);
    println!("from the restart to a map of 800 nodes in force: {seconds:.3} s");
    assert!(seconds <= MOST_S);
    assert_eq!(rig.status().missed, 0);
    // In the middle of its next one, and in its last double word.
    for cut in [steps / 2, steps - 1] {
        rig.flash.0.borrow_mut().cut_after(cut);
        map::store_map(&mut rig.link, place(), header.clone(), &nodes).expect_err("it was cut");
        rig.link.reconnect().expect("the board is back");
        placed_s(&mut rig);
        let StoredMap::InForce { slot: 0, .. } = rig.status().stored_map else {
            panic!("{:?}", rig.status().stored_map)
        };
    }
    // Where no beacon is, a mark does: where the courier stands, in the map's count.
    let status = rig.status();
    let StoredMap::InForce { ahead, .. } = status.stored_map else {
        panic!("{:?}", status.stored_map)
    };
    let mark = mark::place([status.pose.x, status.pose.y], ahead);
    rig.world.with_courier(|courier| courier.set_beacon(None));
    rig.link.restart().expect("the board restarts");
    rig.run(500);
    assert_eq!(rig.status().map, None);
    let at_mark = |mark| Action::MapAtMark { slot: 0, mark };
    let beside = mark.map(|place| Coordinate {
        fraction_turns: place.fraction_turns + 0.4,
        ..place
    });
    let refused = rig.link.ask(at_mark(beside)).expect_err("no whole teeth");
    assert!(
        refused
            .to_string()
            .contains("wanted whole numbers within 0.25"),
        "{refused}"
    );
    assert_eq!(rig.ask(at_mark(mark)), Reply::Done);
    rig.run(10);
    assert!(rig.status().map.is_some());
    assert_eq!(rig.status().missed, 0);
}

/// An end stop on the input for a reference mark: from 2.4 teeth on along x.
fn stop() -> Mark {
    let pitch_m = f64::from(Geometry::PAPER.pitch_m);
    Mark {
        x_m: [2.4 * pitch_m, 1.0],
        y_m: [-1.0, 1.0],
    }
}

/// Goes to so many teeth along x, no faster than a mark is told at, and comes to rest.
fn go(rig: &mut Rig, teeth: f32) {
    let target = Target {
        x_m: teeth * Geometry::PAPER.pitch_m,
        ..Target::default()
    };
    let order = Action::GoTo {
        target,
        speed_m_per_s: 0.008,
    };
    assert_eq!(rig.ask(order), Reply::Done);
    for _ in 0..20 {
        rig.run(100);
        if !rig.status().moving {
            return;
        }
    }
    panic!("under way for 2 s");
}

#[test]
fn the_boards_own_mark_puts_the_map_in_force_where_no_beacon_is() {
    let (mut rig, _) = Rig::stored(33);
    rig.world.set_mark(Some(stop()));
    let (header, nodes) = largest();
    map::store_map(&mut rig.link, place(), header, &nodes).expect("it is stored");
    placed_s(&mut rig);
    let refused = rig.link.ask(Action::MapKeepMark).expect_err("not crossed");
    assert!(refused.to_string().contains("mark"), "{refused}");
    go(&mut rig, 3.0);
    assert_eq!(rig.ask(Action::MapKeepMark), Reply::Done);
    let slot = map::slot(&mut rig.link, 0).expect("a slot");
    let [x, _] = slot.mark.expect("it is kept");
    let crossed_teeth = f64::from(x.teeth) + f64::from(x.fraction_turns);
    // The courier's own errors are some hundredths of a tooth.
    assert!((crossed_teeth - 2.4).abs() < 0.1, "{x:?}");
    go(&mut rig, 0.0);
    rig.world.with_courier(|courier| courier.set_beacon(None));
    rig.link.restart().expect("the board restarts");
    rig.run(500);
    let waits = StoredMap::Waits(Unusable::NoBeaconNorMark);
    assert_eq!(rig.status().stored_map, waits);
    go(&mut rig, 3.0);
    let status = rig.status();
    let StoredMap::InForce { slot: 0, ahead, .. } = status.stored_map else {
        panic!("{:?}", status.stored_map)
    };
    let here = mark::place([status.pose.x, status.pose.y], ahead);
    for (along, wanted_teeth) in here.into_iter().zip([3.0, 0.0]) {
        let teeth = f64::from(along.teeth) + f64::from(along.fraction_turns);
        assert!((teeth - wanted_teeth).abs() < 0.1, "{here:?}");
    }
    assert_eq!(status.missed, 0);
}

#[test]
fn a_map_leaves_the_background_its_time() {
    let (mut rig, _) = Rig::stored(31);
    for with_map in [false, true] {
        if with_map {
            let (header, nodes) = largest();
            map::load_map(&mut rig.link, header, &nodes).expect("it comes in force");
        }
        assert_eq!(rig.status().map.is_some(), with_map);
        for decimation in [1, 2, 5, 20] {
            let (dropped, latest) = streamed(&mut rig, decimation);
            println!(
                "map {with_map}, one sample in {decimation} streamed: {dropped} frames of {FRAMES} not taken up, a reply within {latest:?}"
            );
            assert!(latest < LATEST_REPLY, "{latest:?}");
            // More than one sample in five streamed is more than the background has time for beside a map: frames are left out, and
            // counted. The demonstration streams one in five; a mean that lacks 5 % has 2.5 % more noise.
            let most = match (with_map, decimation) {
                (false, _) => 0,
                (true, 1 | 2) => u32::MAX,
                (true, _) => FRAMES / 20,
            };
            assert!(dropped <= most, "{dropped}");
        }
    }
    rig.assert_none_missed();
    rig.ask(Action::MapDrop);
    assert!(rig.status().map.is_none());
}
