//! Whole teeth by the board's own reference mark, 10,000 starts: never wrong ones, and refused where the mark was moved.

use super::tries::{PITCH_M, TRIES, coordinate, normal};
use courier_sensor::app::homing::Homing;
use courier_sensor::frame::{Coordinate, Frame};
use courier_sensor::link::message::StoredMap;
use courier_sensor::maps::crossing::Crossing;
use courier_sensor::maps::mark::place;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RATE_HZ: f32 = 20_000.0;
/// The background sees every tenth frame at the least.
const EVERY: u32 = 10;
/// By how much a switch and the way to it differ from one crossing to the next, teeth. A prior: 20 µm along both axes.
const REPEATS_TEETH: f64 = 0.02;
/// Contacts bounce for so long at the most, seconds.
const BOUNCE_S: f64 = 3.0e-3;

/// One crossing of a mark at `mark_teeth`, along x, by a board that counts this much ahead: the place that is told.
fn crossed(rng: &mut ChaCha8Rng, mark_teeth: [f64; 2], ahead: [i32; 2]) -> [Coordinate; 2] {
    let speed = rng.random_range(1.0e-3..9.9e-3) / PITCH_M;
    let drift = rng.random_range(-0.1..0.1) * speed;
    let edge_s = rng.random_range(5.0e-3..10.0e-3);
    let bounce_s = rng.random_range(0.0..BOUNCE_S);
    let at_edge = mark_teeth.map(|teeth| teeth + normal(rng, REPEATS_TEETH));
    let mut crossing = Crossing::default();
    let told = (0..).step_by(EVERY as usize).find_map(|sequence: u32| {
        let since_s = f64::from(sequence) / f64::from(RATE_HZ) - edge_s;
        let is_on = since_s > bounce_s || (since_s > 0.0 && rng.random_bool(0.5));
        let place = |axis: usize, speed: f64| {
            coordinate(at_edge[axis] + speed * since_s + f64::from(ahead[axis]))
        };
        let mut frame = Frame {
            sequence,
            speed_m_s: [speed, drift].map(|speed| (speed * PITCH_M) as f32),
            ..Frame::default()
        };
        (frame.pose.x, frame.pose.y) = (place(0, speed), place(1, drift));
        crossing.look(&frame, is_on, RATE_HZ)
    });
    told.expect("an endless way")
}

/// A mark's place is kept with a map in force; a later start crosses it, `moved` teeth beside where it was: what is found, what it should be,
/// and the state.
fn start(rng: &mut ChaCha8Rng, moved: [f64; 2]) -> (Option<[i32; 2]>, [i32; 2], StoredMap) {
    let mark = [(); 2].map(|()| rng.random_range(-500.0..500.0));
    let counts = |rng: &mut ChaCha8Rng| [(); 2].map(|()| rng.random_range(-600..600));
    let before = counts(rng);
    let counted = crossed(rng, mark, before);
    let kept = place(
        counted,
        before.map(|teeth| Coordinate {
            teeth,
            fraction_turns: 0.0,
        }),
    );
    let now = counts(rng);
    let counted = crossed(rng, [0, 1].map(|axis| mark[axis] + moved[axis]), now);
    let mut homing = Homing::default();
    homing.begin(false, |slot| {
        (slot == 1).then(|| (super::info("a", 1), true, true))
    });
    homing.crossed(&counted, |slot| (slot == 1).then_some(kept));
    let found = homing.found();
    assert!(found.is_none_or(|found| found.slot == 1));
    (found.map(|found| found.ahead_teeth()), now, homing.state())
}

#[test]
fn ten_thousand_crossings_find_the_right_teeth() {
    let mut rng = ChaCha8Rng::seed_from_u64(3910);
    let mut refused = 0;
    for _ in 0..TRIES {
        match start(&mut rng, [0.0; 2]) {
            (None, ..) => refused += 1,
            (Some(found), wanted, _) => assert_eq!(found, wanted),
        }
    }
    println!(
        "right teeth in {} crossings of {TRIES}, refused {refused}, wrong 0",
        TRIES - refused
    );
    // Two crossings differ by 0.03 teeth, one normal deviation, and by up to 0.03 of a bounce: a quarter is 7 of them.
    assert_eq!(refused, 0);
}

#[test]
fn a_mark_that_was_moved_by_half_a_tooth_is_refused_with_numbers() {
    let mut rng = ChaCha8Rng::seed_from_u64(3911);
    let mut wrong = 0;
    for index in 0..TRIES {
        let mut moved = [0.0; 2];
        moved[index % 2] = f64::from(rng.random_range(-50..50)) + 0.5;
        match start(&mut rng, moved) {
            (Some(_), ..) => wrong += 1,
            (None, _, state) => assert!(matches!(state, StoredMap::NotWhole { slot: 1, .. })),
        }
    }
    println!("a mark moved by half a tooth: taken for unmoved in {wrong} crossings of {TRIES}");
    // The same quarter of a tooth from the other side.
    assert_eq!(wrong, 0);
}
