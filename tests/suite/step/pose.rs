//! From phases to pose, parity, tooth count and speed.

use super::{BEACON, PITCH_M, at, calibrated, pair, raw, run};
use courier_sensor::beacon::BeaconSettings;
use courier_sensor::frame::{RawFrame, SEGMENTS, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn pose_and_parity_are_those_of_equations_4_and_5() {
    let span = f64::from(Geometry::PAPER.span_m);
    let mut settings = calibrated();
    settings.limits.frozen_samples = 0;
    let positions = |k: u32| {
        let k = f64::from(k);
        [
            300.0 + 0.071 * k,
            -20.0 - 0.033 * k,
            299.9 + 0.071 * k,
            -20.2 - 0.033 * k,
        ]
    };
    for (k, frame) in run(&settings, (0..4000).map(|k| raw(positions(k))))
        .iter()
        .enumerate()
    {
        let p = positions(k as u32);
        // The count starts at the first sample's phase.
        let (x, y) = (0.5 * (p[0] + p[2]) - 300.0, 0.5 * (p[1] + p[3]) + 20.0);
        assert!(
            (frame.pose.x.metres(1.016e-3) - x * PITCH_M).abs() < 12e-9,
            "{k}"
        );
        assert!(
            (frame.pose.y.metres(1.016e-3) - y * PITCH_M).abs() < 12e-9,
            "{k}"
        );
        assert!((f64::from(frame.pose.theta_x_rad) - 0.1 * PITCH_M / span).abs() < 3e-6);
        assert!((f64::from(frame.pose.theta_y_rad) - 0.2 * PITCH_M / span).abs() < 3e-6);
        assert!((f64::from(frame.pose.theta_rad) - 0.15 * PITCH_M / span).abs() < 3e-6);
        assert!((f64::from(frame.parity_m) + 0.1 * PITCH_M).abs() < 25e-9);
        assert_eq!(frame.status, Status::empty(), "{k}");
        assert_eq!(frame.sequence, k as u32);
    }
}

/// 1.5 m/s at 20 kHz is 0.0738 pitches a sample; started and stopped and turned within one sample each, with noise of
/// 30 counts rms (ten times what the converter has) at a low amplitude.
#[test]
fn no_tooth_is_lost_at_full_speed_with_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let step_turns = 1.5 / 20_000.0 / PITCH_M;
    let mut x = 0.0;
    let mut truth = Vec::new();
    let mut raws = Vec::new();
    for k in 0..60_000 {
        let direction = [0.0, 1.0, -1.0, 1.0, 0.0, -1.0][k / 10_000];
        x += direction * step_turns;
        let noisy = |turns: f64, rng: &mut ChaCha8Rng| {
            pair(5000.0, turns).map(|c| {
                let n: f64 = StandardNormal.sample(rng);
                c + (30.0 * n).round() as i16
            })
        };
        truth.push(x);
        raws.push(RawFrame {
            quadrature_counts: at(x, -0.7 * x, 0.01).map(|t| noisy(t, &mut rng)),
            electrode_counts: BEACON,
            ..RawFrame::default()
        });
    }
    for (frame, x) in run(&calibrated(), raws).iter().zip(truth) {
        assert_eq!(frame.status, Status::empty(), "sample {}", frame.sequence);
        for (segment, p) in frame.segments.iter().zip(at(x, -0.7 * x, 0.01)) {
            let seen =
                f64::from(segment.unmodified.teeth) + f64::from(segment.unmodified.fraction_turns);
            assert!((seen - p).abs() < 0.01, "sample {}", frame.sequence);
        }
    }
}

/// A jump by a whole tooth looks like none to one segment; the others know.
#[test]
fn a_wrong_count_shows_in_the_parity() {
    let config = StepConfig::build(&calibrated()).unwrap();
    let mut state = StepState::new();
    assert_eq!(
        step(&config, &mut state, &raw([0.1; 4])).status,
        Status::empty()
    );
    for i in 0..SEGMENTS {
        let mut teeth = [5; SEGMENTS];
        teeth[i] += 1;
        state.set_teeth(teeth);
        assert_eq!(
            step(&config, &mut state, &raw([0.1; 4])).status,
            Status::PARITY
        );
        state.set_teeth([5; SEGMENTS]);
        let frame = step(&config, &mut state, &raw([0.1; 4]));
        assert_eq!(frame.status, Status::empty());
        assert_eq!(frame.segments[i].unmodified.teeth, 5);
    }
}

#[test]
fn the_first_sample_counts_pairs_together() {
    let frame = run(&calibrated(), [raw([0.45, -0.45, 0.55, -0.52])])[0];
    assert_eq!(frame.segments.map(|s| s.unmodified.teeth), [0, 0, 1, -1]);
    assert!(frame.pose.theta_rad.abs() < 0.02);
}

#[test]
fn speed_is_the_filtered_one() {
    let frames = run(
        &calibrated(),
        (0..400).map(|k| raw(at(0.05 * f64::from(k), -0.02 * f64::from(k), 0.0))),
    );
    let last = frames.last().unwrap();
    assert!((f64::from(last.speed_m_s[0]) - 0.05 * PITCH_M * 2.0e4).abs() < 1e-4);
    assert!((f64::from(last.speed_m_s[1]) + 0.02 * PITCH_M * 2.0e4).abs() < 1e-4);
}

#[test]
fn direction_is_held_within_the_dead_band() {
    let settings = Settings {
        track_direction: true,
        ..calibrated()
    };
    let path = (0..200)
        .map(|k| f64::from(k) * 0.01)
        .chain(std::iter::repeat_n(1.99, 2000));
    let frames = run(&settings, path.map(|x| raw(at(x, -x, 0.0))));
    assert_eq!(frames[0].direction[0], 0.0);
    assert_eq!(frames[199].direction, [1.0, -1.0]);
    assert_eq!(frames[2199].direction, [1.0, -1.0]);
}

#[test]
fn the_pose_under_a_beacon_comes_and_goes_with_it() {
    let beacon = BeaconSettings {
        origin_teeth: [3, -2],
        origin_m: [0.0; 2],
        sensor: [0.0; 16],
        segment_sd_m: 1e-6,
        displacement_sd_m: 1e-6,
    };
    let settings = Settings {
        beacon: Some(beacon),
        ..calibrated()
    };
    let dark = RawFrame {
        electrode_counts: [0; 4],
        ..raw([0.25; SEGMENTS])
    };
    let frames = run(
        &settings,
        [raw([0.25; SEGMENTS]), dark, raw([0.25; SEGMENTS])],
    );
    assert!(frames[0].beacon.seen && frames[2].beacon.seen);
    assert_eq!(frames[1].beacon, Default::default());
    let seen = frames[0].beacon;
    let g = Geometry::PAPER;
    assert!((f64::from(seen.platen.x_m) + 2.75 * PITCH_M).abs() < 30e-9);
    assert!((f64::from(seen.platen.y_m) - 2.25 * PITCH_M).abs() < 30e-9);
    assert!((seen.sensor.x_m - g.lever_m[0] - g.height_m * frames[0].tan_psi[0]).abs() < 1e-7);
    assert!((seen.sensor.y_m - g.lever_m[1]).abs() < 1e-6);
    assert!(!run(&calibrated(), [raw([0.25; SEGMENTS])])[0].beacon.seen);
}
