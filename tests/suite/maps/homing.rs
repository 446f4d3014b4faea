//! Whole teeth by the beacon, 10,000 starts: never wrong ones, and refused where a beacon was moved.

use super::tries::{PITCH_M, TRIES, coordinate, normal};
use courier_sensor::app::homing::Homing;
use courier_sensor::calibration::rest_watch::{FASTEST_M_S, MOST_DEFLECTION};
use courier_sensor::frame::{Coordinate, Frame, Pose, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::StoredMap;
use courier_sensor::maps::fit::{CELLS, FitOfMap, LEAST_PARITY_M};
use courier_sensor::maps::homing::{Anchor, MOST_LEFT_TURNS, Mean, Unusable, check, whole_teeth};
use effects::motion::Pose as True;
use effects::plant;
use hal_sim::coordination::{deflection, origin_under};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Frames of a window that the background sees at the least.
const FRAMES: usize = 50;
/// What a joint calibration leaves of h, l_x and l_y (the paper, 3.2.1).
const MOUNTING_SD_M: f64 = 20.0e-6;
/// Of x and y, and of theta (the paper, 3.2.1: 2.9 µm and 0.43 mrad).
const POSITION_SD_M: f64 = 2.9e-6;
const THETA_SD_RAD: f64 = 0.43e-3;
/// Deviation of one frame: of a displacement and of x, y (2 of 30,000 and 20 of 20,000 counts), of theta.
const NOISE: [f64; 3] = [0.5e-6, 0.2e-6, 12.0e-6];
/// Cube of the diode, of full scale (Golnabi: up to 17 %).
const CUBE: f64 = 0.17;

/// One start of a board under a beacon that stands `moved_teeth` beside where it stood: what was found, and what it should be.
fn start(rng: &mut ChaCha8Rng, moved_teeth: [f64; 2]) -> (Option<[i32; 2]>, [i32; 2]) {
    let nominal = Geometry::PAPER;
    let truth = plant::Geometry {
        height_m: f64::from(nominal.height_m) + rng.random_range(-2.5e-3..2.5e-3),
        lever_m: nominal
            .lever_m
            .map(|l| f64::from(l) + rng.random_range(-1.0e-3..1.0e-3)),
        ..plant::Geometry::PAPER
    };
    let beacon = True::new(rng.random_range(0.0..0.5), rng.random_range(0.0..0.5), 0.0);
    let anchor_turns = [beacon.x_m, beacon.y_m].map(|p| coordinate(p / PITCH_M));
    let anchor = Anchor {
        beacon_teeth: anchor_turns.map(|turns| turns.teeth),
        beacon_m: anchor_turns.map(|turns| {
            (f64::from(turns.fraction_turns) * PITCH_M + normal(rng, POSITION_SD_M)) as f32
        }),
        height_m: (truth.height_m + normal(rng, MOUNTING_SD_M)) as f32,
        lever_m: truth
            .lever_m
            .map(|l| (l + normal(rng, MOUNTING_SD_M)) as f32),
    };
    let moved = True::new(
        beacon.x_m + moved_teeth[0] * PITCH_M,
        beacon.y_m + moved_teeth[1] * PITCH_M,
        0.0,
    );
    let origin_m = origin_under(&truth, moved);
    // Where the courier stands: within what the diode's middle allows.
    let most_m = 0.4 * truth.height_m * truth.tan_full_scale;
    let theta_rad = rng.random_range(-26.0e-3..26.0e-3);
    let offset_m = [(); 2].map(|()| rng.random_range(-most_m..most_m));
    let here = hal_sim::coordination::pose_under(&truth, origin_m, offset_m, theta_rad);
    let bent = deflection(&truth, origin_m, here).map(|u| u + CUBE * u.powi(3));
    let ahead = [(); 2].map(|()| rng.random_range(-600..600));
    let wrong = [POSITION_SD_M, POSITION_SD_M, THETA_SD_RAD].map(|sd| normal(rng, sd));
    let mut mean = Mean::default();
    for _ in 0..FRAMES {
        let [d, p, t] = NOISE;
        let place_m = [here.x_m + wrong[0], here.y_m + wrong[1]].map(|m| m + normal(rng, p));
        let counted: [Coordinate; 2] =
            std::array::from_fn(|k| coordinate(place_m[k] / PITCH_M + f64::from(ahead[k])));
        let pose = Pose {
            x: counted[0],
            y: counted[1],
            theta_rad: (theta_rad + wrong[2] + normal(rng, t)) as f32,
            ..Pose::default()
        };
        let tan_psi =
            bent.map(|u| (u * truth.tan_full_scale + normal(rng, d) / truth.height_m) as f32);
        mean.add(&anchor.ahead(&nominal, &pose, tan_psi));
    }
    let mean = mean.mean().expect("the frames agree");
    (whole_teeth(&mean), ahead)
}

#[test]
fn ten_thousand_starts_find_the_right_teeth() {
    let mut rng = ChaCha8Rng::seed_from_u64(39);
    let mut refused = 0;
    for _ in 0..TRIES {
        match start(&mut rng, [0.0; 2]) {
            (None, _) => refused += 1,
            (Some(found), wanted) => assert_eq!(found, wanted),
        }
    }
    println!(
        "right teeth in {} starts of {TRIES}, refused {refused}, wrong 0",
        TRIES - refused
    );
    // y's error is theta's at the end of the lever arm, 0.04 teeth, and up to 0.05 of the diode's cube: a quarter is 5 deviations.
    assert!(refused <= TRIES / 1000, "{refused}");
}

#[test]
fn a_beacon_that_was_moved_is_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(40);
    let mut accepted = 0;
    for index in 0..TRIES {
        let mut moved = [0.0; 2];
        moved[index % 2] = f64::from(rng.random_range(-50..50)) + rng.random_range(0.49..0.51);
        accepted += usize::from(start(&mut rng, moved).0.is_some());
    }
    println!("a beacon moved by half a tooth: taken for unmoved in {accepted} starts of {TRIES}");
    assert_eq!(accepted, 0);
}

#[test]
fn a_quarter_of_a_tooth_is_the_limit() {
    let ahead = |left: f32| {
        [
            Coordinate {
                teeth: 3,
                fraction_turns: left,
            },
            Coordinate::default(),
        ]
    };
    assert_eq!(whole_teeth(&ahead(MOST_LEFT_TURNS)), Some([3, 0]));
    assert_eq!(whole_teeth(&ahead(-MOST_LEFT_TURNS)), Some([3, 0]));
    assert_eq!(whole_teeth(&ahead(0.2501)), None);
    assert_eq!(whole_teeth(&ahead(f32::NAN)), None);
}

#[test]
fn frames_that_tell_nothing_say_what_they_lack() {
    let geometry = Geometry::PAPER;
    let good = Frame {
        status: Status::UNCALIBRATED | Status::CALIBRATION_DRIFT,
        ..Frame::default()
    };
    assert_eq!(check(&good, &geometry), Ok(()));
    let far = MOST_DEFLECTION * geometry.tan_full_scale * 1.01;
    let cases = [
        (
            Frame {
                status: Status::BEACON_MISSING,
                ..good
            },
            Unusable::NoBeacon,
        ),
        (
            Frame {
                status: Status::SLIP_3,
                ..good
            },
            Unusable::Doubtful,
        ),
        (
            Frame {
                status: Status::OVERRUN,
                ..good
            },
            Unusable::Doubtful,
        ),
        (
            Frame {
                speed_m_s: [0.0, 1.1 * FASTEST_M_S],
                ..good
            },
            Unusable::TooFast,
        ),
        (
            Frame {
                speed_m_s: [f32::NAN, 0.0],
                ..good
            },
            Unusable::TooFast,
        ),
        (
            Frame {
                tan_psi: [0.0, -far],
                ..good
            },
            Unusable::TooFarOff,
        ),
    ];
    for (frame, lacks) in cases {
        assert_eq!(check(&frame, &geometry), Err(lacks));
    }
}

#[test]
fn frames_that_disagree_have_no_mean() {
    let ahead = |turns: f64| [coordinate(turns), coordinate(-7.0)];
    let mut mean = Mean::default();
    assert_eq!(mean.mean(), None);
    // About a border of two counts.
    for turns in [4.49, 4.51, 4.50, 4.50] {
        mean.add(&ahead(turns));
    }
    let [x, y] = mean.mean().unwrap();
    assert!((f64::from(x.teeth) + f64::from(x.fraction_turns) - 4.5).abs() < 1e-6);
    assert_eq!(y, coordinate(-7.0));
    mean.add(&ahead(5.5));
    assert_eq!(mean.mean(), None, "a slip");
}

/// A frame under the beacon of [`super::info`], 5 and -3 teeth ahead.
fn under_the_beacon(sequence: u32, speed_m_s: f32) -> Frame {
    let mut frame = Frame {
        sequence,
        speed_m_s: [speed_m_s, 0.0],
        ..Frame::default()
    };
    let anchor = super::info("a", 1).anchor;
    let pitch_m = Geometry::PAPER.pitch_m;
    let place = |axis: usize, ahead| Coordinate {
        teeth: anchor.beacon_teeth[axis] + ahead,
        fraction_turns: anchor.beacon_m[axis] / pitch_m,
    };
    (frame.pose.x, frame.pose.y) = (place(0, 5), place(1, -3));
    frame
}

/// Frames at 20 kHz, of which the background sees every tenth: what is found after so long.
fn looked(seconds: f32, frame: impl Fn(u32) -> Frame) -> (Option<[i32; 2]>, StoredMap) {
    let (mut homing, rate_hz) = (Homing::default(), 20_000.0);
    homing.begin(false, |slot| {
        (slot == 2).then(|| (super::info("a", 1), true, false))
    });
    for sequence in (0..(seconds * rate_hz) as u32).step_by(10) {
        homing.look(&frame(sequence), &Geometry::PAPER, rate_hz);
    }
    let found = homing.found();
    assert!(found.is_none_or(|found| found.slot == 2));
    (found.map(|found| found.ahead_teeth()), homing.state())
}

#[test]
fn a_vibration_is_averaged_and_a_motion_waited_for() {
    let still = |sequence| under_the_beacon(sequence, 0.0);
    assert_eq!(looked(0.24, still).0, None, "not yet a window");
    assert_eq!(looked(0.26, still).0, Some([5, -3]));
    let vibrates =
        |sequence| under_the_beacon(sequence, if sequence % 40 < 20 { 0.05 } else { 0.0 });
    assert_eq!(looked(0.26, vibrates).0, Some([5, -3]));
    let moves = |sequence| under_the_beacon(sequence, 0.05);
    let waits = StoredMap::Waits(Unusable::TooFast);
    assert_eq!(looked(1.0, moves), (None, waits));
    // A slip in the middle of each window: nothing of before counts.
    let slips = |sequence: u32| {
        let mut frame = still(sequence);
        if sequence % 4000 == 0 {
            frame.status = Status::SLIP_2;
        }
        frame
    };
    assert_eq!(looked(1.0, slips).0, None);
}

/// What a map leaves of g_p, at the least that is taken.
const LEFT_M: f64 = LEAST_PARITY_M as f64;

/// g_p in cells that the courier comes through, of this deviation.
fn judged(rng: &mut impl Rng, parity_sd_m: f64, cells: i32) -> Option<bool> {
    let mut fit = FitOfMap::default();
    for teeth in 0..=cells {
        let sample: f64 = StandardNormal.sample(rng);
        let mut frame = Frame {
            status: Status::CALIBRATION_DRIFT | Status::BEACON_MISSING,
            parity_m: (parity_sd_m * sample) as f32,
            ..Frame::default()
        };
        frame.pose.x.teeth = teeth;
        (0..3).for_each(|_| fit.add(&frame));
        frame.status = Status::OUTSIDE_MAP;
        frame.parity_m = 1.0;
        fit.add(&frame);
    }
    fit.parity(LEFT_M as f32).fits()
}

/// A beacon moved by whole teeth, or another platen: its own teeth's 4 µm and the map's (the paper, 3.1.2).
#[test]
fn another_platens_teeth_are_told_within_8_cells_and_the_maps_own_never() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    assert_eq!(judged(&mut rng, LEFT_M, i32::from(CELLS) - 1), None);
    for _ in 0..TRIES {
        assert_eq!(judged(&mut rng, LEFT_M, CELLS.into()), Some(true));
    }
    let told = (0..TRIES)
        .filter(|_| judged(&mut rng, 4.0e-6 * 2f64.sqrt(), CELLS.into()) == Some(false))
        .count();
    println!("another platen told in {told} of {TRIES}");
    // The mean square of 8 normal values is below 3 % of its expectation once in 100,000.
    assert!(told >= TRIES - 2, "{told}");
}
