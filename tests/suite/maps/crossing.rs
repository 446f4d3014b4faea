//! The board's own reference mark: which edges of its input count, and how its place is kept through power cuts.

use super::*;
use courier_sensor::app::keeper::entries::{add, last};
use courier_sensor::frame::{Coordinate, Frame, Status};
use courier_sensor::maps::crossing::{BYTES, Crossing, from_bytes, to_bytes};

const RATE_HZ: f32 = 20_000.0;
const PITCH_M: f32 = 1.016e-3;

/// A frame of a courier that goes along x at this speed, from tooth 7 on.
fn going(sequence: u32, speed_m_s: f32) -> Frame {
    let turns = speed_m_s / PITCH_M * sequence as f32 / RATE_HZ;
    let mut frame = Frame {
        sequence,
        speed_m_s: [speed_m_s, 0.0],
        ..Frame::default()
    };
    frame.pose.x = Coordinate {
        teeth: 7 + turns.floor() as i32,
        fraction_turns: turns - turns.floor(),
    };
    frame
}

/// Looks at every tenth frame for so long; places that were told, turns along x.
fn told(seconds: f32, speed_m_s: f32, is_on: impl Fn(u32) -> bool) -> Vec<f32> {
    let mut crossing = Crossing::default();
    let numbers = (0..(seconds * RATE_HZ) as u32).step_by(10);
    let places = numbers.filter_map(|sequence| {
        crossing.look(&going(sequence, speed_m_s), is_on(sequence), RATE_HZ)
    });
    let turns = places.map(|place| place[0].teeth as f32 + place[0].fraction_turns);
    turns.collect()
}

/// Half a second at 8 mm/s.
const EDGE: u32 = 10_000;
const SLOW_M_S: f32 = 0.008;

#[test]
fn the_edge_tells_the_place_and_bounces_spikes_and_fast_crossings_do_not() {
    let wanted = 7.0 + 0.5 * SLOW_M_S / PITCH_M;
    let crossed = told(1.0, SLOW_M_S, |sequence| sequence > EDGE);
    assert_eq!(crossed.len(), 1);
    // Every tenth frame is 4 µm on.
    assert!((crossed[0] - wanted).abs() < 0.01, "{crossed:?} {wanted}");
    // Contacts that bounce for 3 ms: the last edge counts, 24 µm on.
    let bounces = |sequence: u32| sequence > EDGE && (sequence > EDGE + 60 || sequence % 20 == 0);
    let crossed = told(1.0, SLOW_M_S, bounces);
    assert_eq!(crossed.len(), 1);
    assert!((crossed[0] - wanted).abs() < 0.05, "{crossed:?} {wanted}");
    // Off again after 9 ms, and a start on the mark: no edge.
    let spike = |sequence: u32| (EDGE..EDGE + 180).contains(&sequence);
    assert!(told(1.0, SLOW_M_S, spike).is_empty());
    assert!(told(1.0, SLOW_M_S, |_| true).is_empty());
    assert!(told(1.0, 0.02, |sequence| sequence > EDGE).is_empty());
}

#[test]
fn frames_that_lie_apart_and_a_doubtful_count_tell_no_place() {
    let mut crossing = Crossing::default();
    crossing.look(&going(0, SLOW_M_S), false, RATE_HZ);
    // The main loop has stood still for 10 ms: 80 µm.
    let late =
        |crossing: &mut Crossing, number| crossing.look(&going(number, SLOW_M_S), true, RATE_HZ);
    assert_eq!(late(&mut crossing, 200), None);
    assert_eq!(late(&mut crossing, 1000), None);
    for sequence in (1010..4000).step_by(10) {
        let on = sequence > 2000;
        crossing.look(&going(sequence, SLOW_M_S), on, RATE_HZ);
    }
    assert!(crossing.last().is_some());
    let mut slip = going(4000, SLOW_M_S);
    slip.status = Status::SLIP_2;
    crossing.look(&slip, true, RATE_HZ);
    assert_eq!(crossing.last(), None);
}

/// A flash with one map, and its slot.
fn with_one_map() -> (Flash, u8) {
    let mut flash = flash(1);
    let slot = store(&mut flash, "a", 1).unwrap();
    (flash, slot)
}

fn at(teeth: i32) -> [Coordinate; 2] {
    [0.25, -0.4].map(|fraction_turns| Coordinate {
        teeth,
        fraction_turns,
    })
}

#[test]
fn a_cut_leaves_the_place_before_or_the_new_one_and_the_map() {
    let (mut flash, slot) = with_one_map();
    let keep = |flash: &mut Flash, teeth| {
        let room = maps(flash).places(slot);
        add(flash, &room, &to_bytes(&at(teeth)))
    };
    let kept = |flash: &mut Flash| {
        let room = maps(flash).places(slot);
        last(flash, &room, from_bytes).map(|place| place[0].teeth)
    };
    assert_eq!(kept(&mut flash), None);
    assert!(keep(&mut flash, 1));
    let before = flash.steps();
    assert!(keep(&mut flash, 2));
    let steps = flash.steps() - before;
    assert!(steps >= BYTES as u64 / 8, "{steps}");
    for cut in 0..=steps {
        let (mut flash, _) = with_one_map();
        assert!(keep(&mut flash, 1));
        flash.cut_after(cut);
        keep(&mut flash, 2);
        flash.power_up();
        let now = kept(&mut flash);
        assert!(
            now == Some(2) || (now == Some(1) && cut < steps),
            "{cut}: {now:?}"
        );
        assert!(maps(&mut flash).current(slot).is_some(), "cut {cut}");
        assert!(keep(&mut flash, 3), "cut {cut}");
        assert_eq!(kept(&mut flash), Some(3), "cut {cut}");
    }
}

#[test]
fn there_is_room_for_17_places_and_the_largest_map() {
    let (mut flash, slot) = with_one_map();
    let room = maps(&mut flash).places(slot);
    for teeth in 0..17 {
        assert!(add(&mut flash, &room, &to_bytes(&at(teeth))));
    }
    assert!(!add(&mut flash, &room, &to_bytes(&at(17))));
    let place = last(&mut flash, &room, from_bytes);
    assert_eq!(place, Some(at(16)));
    // The mark of a map that is forgotten lies behind them.
    maps(&mut flash).forget(slot).unwrap();
    assert_eq!(last(&mut flash, &room, from_bytes), place);
    assert!(maps(&mut flash).current(slot).is_none());
}
