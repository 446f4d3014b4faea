//! The signal path from counts to frame: what the documentation quotes, every status bit, and no surprise for any input.

use courier_sensor::beacon::BeaconSettings;
use courier_sensor::frame::{Frame, RawFrame, SEGMENTS, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};
use courier_sensor::quadrature::PairCorrection;
use courier_sensor::settings::{ConfigError, Limits, Settings};
use courier_sensor::step::{StepConfig, StepState, isr_step, step};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const PITCH_M: f64 = Geometry::PAPER.pitch_m as f64;
const BEACON: [i16; 4] = [6000, 5000, 5500, 5500];

/// Counts of a perfect pair.
fn pair(amplitude: f64, turns: f64) -> [i16; 2] {
    let (s, c) = (turns * TAU).sin_cos();
    [
        (amplitude * s).round() as i16,
        (amplitude * c).round() as i16,
    ]
}

/// A frame of perfect pairs at these positions in turns, with a beacon.
fn raw(turns: [f64; SEGMENTS]) -> RawFrame {
    RawFrame {
        quadrature_counts: turns.map(|t| pair(25_000.0, t)),
        electrode_counts: BEACON,
        ..RawFrame::default()
    }
}

/// Segments' positions in turns from x, y and half the difference of a pair.
fn at(x: f64, y: f64, half: f64) -> [f64; SEGMENTS] {
    [x + half, y + half, x - half, y - half]
}

fn calibrated() -> Settings {
    Settings {
        model: Some(ErrorModel::zero(TermTable::equation_3())),
        ..Settings::default()
    }
}

fn run(settings: &Settings, raws: impl IntoIterator<Item = RawFrame>) -> Vec<Frame> {
    let config = StepConfig::build(settings).unwrap();
    let mut state = StepState::new();
    raws.into_iter()
        .map(|raw| step(&config, &mut state, &raw))
        .collect()
}

fn phase_of(counts: [i16; 2]) -> f64 {
    f64::from(counts[0]).atan2(f64::from(counts[1])) / TAU
}

fn nearest(difference_turns: f64) -> f64 {
    difference_turns - difference_turns.round()
}

/// Within 0.3 nm of atan2 in f64 of the same counts, where 5 nm are asked for.
#[test]
fn interpolation_is_within_0_3_nm_at_every_phase_and_amplitude() {
    let mut worst_m = 0.0_f64;
    let raws = (0..40_000).map(|k| {
        let amplitude = 4000.0 + 28_000.0 * f64::from(k % 97) / 96.0;
        let phase = f64::from(k) / 40_000.0;
        let counts = pair(amplitude, phase);
        RawFrame {
            quadrature_counts: [counts; 4],
            electrode_counts: BEACON,
            ..RawFrame::default()
        }
    });
    for frame in run(&calibrated(), raws) {
        for (segment, counts) in frame.segments.iter().zip(frame.raw.quadrature_counts) {
            let error = nearest(f64::from(segment.unmodified.fraction_turns) - phase_of(counts));
            worst_m = worst_m.max(error.abs() * PITCH_M);
        }
    }
    assert!(worst_m < 0.3e-9, "{worst_m:e} m");
}

/// Every count pair of a coarse grid, far outside the amplitude limits too: the same bound down to ten counts.
#[test]
fn interpolation_holds_for_any_counts() {
    let values = || (-32_768..=32_767).step_by(331).chain([-1, 0, 1, 32_767]);
    let raws = values()
        .flat_map(|s| values().map(move |c| [s as i16, c as i16]))
        .map(|counts| RawFrame {
            quadrature_counts: [counts; 4],
            ..RawFrame::default()
        });
    for frame in run(&calibrated(), raws) {
        let [s, c] = frame.raw.quadrature_counts[1];
        if f64::from(s).hypot(f64::from(c)) > 10.0 {
            let error =
                nearest(f64::from(frame.segments[1].unmodified.fraction_turns) - phase_of([s, c]));
            assert!(error.abs() * PITCH_M < 0.3e-9, "{s} {c}: {error:e}");
        }
    }
}

#[test]
fn amplitude_is_the_vectors_length() {
    for frame in run(
        &calibrated(),
        (0..1000).map(|k| raw(at(f64::from(k) * 0.011, 0.3, 0.0))),
    ) {
        for (segment, counts) in frame.segments.iter().zip(frame.raw.quadrature_counts) {
            let exact = f64::from(counts[0]).hypot(f64::from(counts[1]));
            assert!((f64::from(segment.amplitude_counts) / exact - 1.0).abs() < 2e-6);
        }
    }
}

#[test]
fn pair_correction_undoes_offset_gain_and_angle() {
    let wrong = PairCorrection {
        offset_counts: [800.0, -1500.0],
        gain: 1.13,
        angle_rad: 0.14,
    };
    let settings = Settings {
        pairs: [wrong; 4],
        ..calibrated()
    };
    let raws: Vec<_> = (0..5000)
        .map(|k| {
            let phi = TAU * f64::from(k) * 0.0137;
            let s = 800.0 + 24_000.0 * phi.sin();
            let c = -1500.0 + 24_000.0 * 1.13 * (phi + 0.14).cos();
            RawFrame {
                quadrature_counts: [[s.round() as i16, c.round() as i16]; 4],
                ..RawFrame::default()
            }
        })
        .collect();
    for (k, frame) in run(&settings, raws).iter().enumerate() {
        let error =
            nearest(f64::from(frame.segments[2].unmodified.fraction_turns) - k as f64 * 0.0137);
        // What is left is the rounding to counts: 0.71 counts of 24000, a little more by the correction.
        assert!(error.abs() < 0.9 / 24_000.0 / TAU, "{error:e}");
        assert!((frame.segments[2].amplitude_counts - 24_000.0).abs() < 1.5);
    }
}

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
fn a_jump_is_a_slip_that_stays_until_cleared() {
    let config = StepConfig::build(&calibrated()).unwrap();
    let mut state = StepState::new();
    for i in 0..SEGMENTS {
        for jump in [0.21, 0.5, -0.3, 0.79] {
            let mut p = [0.1; SEGMENTS];
            state.restart_count();
            (0..50).for_each(|_| _ = step(&config, &mut state, &raw(p)));
            p[i] += jump;
            let slip = Status::from_bits_retain(Status::SLIP_1.bits() << i);
            for _ in 0..100 {
                let status = step(&config, &mut state, &raw(p)).status;
                assert_eq!(status - Status::PARITY, slip, "segment {i}, jump {jump}");
            }
            state.clear_slips();
            assert_eq!(
                step(&config, &mut state, &raw(p)).status - Status::PARITY,
                Status::empty()
            );
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
fn each_amplitude_and_clip_bit_is_its_own() {
    let settings = calibrated();
    let status = |i: usize, counts: [i16; 2]| {
        let mut frame = raw([0.1; SEGMENTS]);
        frame.quadrature_counts[i] = counts;
        run(&settings, [frame])[0].status - Status::PARITY
    };
    for i in 0..SEGMENTS {
        let bit = |first: Status| Status::from_bits_retain(first.bits() << i);
        assert_eq!(status(i, [0, 0]), bit(Status::AMPLITUDE_LOW_1));
        assert_eq!(status(i, [3990, 0]), bit(Status::AMPLITUDE_LOW_1));
        assert_eq!(status(i, [0, 4010]), Status::empty());
        assert_eq!(status(i, [-31_990, 0]), Status::empty());
        assert_eq!(status(i, [23_000, -23_000]), bit(Status::AMPLITUDE_HIGH_1));
        for end in [32_760, 32_767, -32_760, -32_768] {
            let both = bit(Status::AMPLITUDE_HIGH_1) | bit(Status::CLIPPED_1);
            assert_eq!(status(i, [end, 5]), both);
            assert_eq!(status(i, [5, end]), both);
        }
        assert_eq!(status(i, [32_759, 0]), bit(Status::AMPLITUDE_HIGH_1));
    }
}

#[test]
fn the_beacon_may_be_missing_or_too_bright() {
    let seen = |electrodes: [i16; 4]| {
        let frame = RawFrame {
            electrode_counts: electrodes,
            ..raw([0.1; SEGMENTS])
        };
        let frame = run(&calibrated(), [frame])[0];
        (frame.tan_psi, frame.status)
    };
    let (tan, status) = seen([6000, 5000, 5000, 7000]);
    assert_eq!(status, Status::empty());
    assert!((f64::from(tan[0]) - 0.1 * 1000.0 / 11_000.0).abs() < 1e-9);
    assert!((f64::from(tan[1]) + 0.1 * 2000.0 / 12_000.0).abs() < 2e-9);
    assert_eq!(seen([0; 4]), ([0.0; 2], Status::BEACON_MISSING));
    assert_eq!(
        seen([400, 500, 6000, 6000]),
        ([0.0; 2], Status::BEACON_MISSING)
    );
    assert_eq!(
        seen([6000, 6000, 3, -30]),
        ([0.0; 2], Status::BEACON_MISSING)
    );
    for k in 0..4 {
        let mut electrodes = [20_000; 4];
        electrodes[k] = 32_767;
        assert_eq!(seen(electrodes).1, Status::BEACON_SATURATED);
        electrodes[k] = i16::MIN;
        assert_eq!(
            seen(electrodes).1,
            Status::BEACON_SATURATED | Status::BEACON_MISSING
        );
    }
}

#[test]
fn what_the_sampler_knows_passes_through() {
    for fault in [
        Status::CONVERTER_CRC,
        Status::CONVERTER_TIMEOUT,
        Status::OVERRUN,
    ] {
        let frame = RawFrame {
            fault,
            ..raw([0.1; SEGMENTS])
        };
        assert_eq!(run(&calibrated(), [frame])[0].status, fault);
    }
    assert_eq!(
        run(&Settings::default(), [raw([0.1; SEGMENTS])])[0].status,
        Status::UNCALIBRATED
    );
}

#[test]
fn previous_counts_stand_in_for_a_failed_conversion() {
    let at = |k: u32| raw(at(0.07 * f64::from(k), 0.0, 0.0));
    let lost = |k: u32| (100..115).contains(&k);
    let frames = run(
        &calibrated(),
        (0..200).map(|k| match lost(k) {
            true => RawFrame {
                fault: Status::CONVERTER_CRC,
                ..RawFrame::default()
            },
            false => at(k),
        }),
    );
    for (frame, k) in frames.iter().zip(0..) {
        let shown = if lost(k) { 99 } else { k };
        let x = f64::from(shown) * 0.07;
        assert!(
            (frame.pose.x.metres(1.016e-3) / PITCH_M - x).abs() < 1e-4,
            "{k}: {:?}",
            frame.pose.x
        );
        assert_eq!(
            frame.status,
            if lost(k) {
                Status::CONVERTER_CRC
            } else {
                Status::empty()
            },
            "{k}"
        );
        assert_eq!(frame.raw.quadrature_counts, at(shown).quadrature_counts);
    }
}

#[test]
fn too_long_a_gap_is_a_slip() {
    let frames = run(
        &calibrated(),
        (0..100).map(|k| match !(20..=52).contains(&k) {
            true => raw([0.1; SEGMENTS]),
            false => RawFrame {
                fault: Status::CONVERTER_TIMEOUT,
                ..raw([0.1; SEGMENTS])
            },
        }),
    );
    let slips = Status::SLIP_1 | Status::SLIP_2 | Status::SLIP_3 | Status::SLIP_4;
    assert_eq!(frames[51].status, Status::CONVERTER_TIMEOUT);
    assert_eq!(frames[52].status, Status::CONVERTER_TIMEOUT | slips);
    assert_eq!(frames[99].status, slips);
}

#[test]
fn a_stuck_channel_is_frozen_and_a_still_courier_is_not() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for stuck in [None, Some((0, 0)), Some((2, 1)), Some((3, 0))] {
        let raws: Vec<_> = (0..5000)
            .map(|k| {
                let mut frame = raw([0.1; SEGMENTS]);
                for (i, pair) in frame.quadrature_counts.iter_mut().enumerate() {
                    for (j, count) in pair.iter_mut().enumerate() {
                        let noise: f64 = StandardNormal.sample(&mut rng);
                        if k < 1500 || stuck != Some((i, j)) {
                            *count += (0.5 * noise).round() as i16;
                        }
                    }
                }
                frame
            })
            .collect();
        let frames = run(&calibrated(), raws);
        assert!(frames[..1500].iter().all(|f| f.status.is_empty()));
        let expected = if stuck.is_some() {
            Status::FROZEN
        } else {
            Status::empty()
        };
        assert!(
            frames[3600..].iter().all(|f| f.status == expected),
            "{stuck:?}"
        );
    }
}

#[test]
fn a_temperature_that_is_none_is_replaced() {
    for delta in [f32::NAN, f32::INFINITY, -2000.0] {
        let frame = RawFrame {
            temperature_delta_k: delta,
            ..raw([0.1; SEGMENTS])
        };
        let frame = run(&calibrated(), [frame])[0];
        assert_eq!(
            (frame.status, frame.raw.temperature_delta_k),
            (Status::NUMERIC, 0.0)
        );
    }
}

/// Random coefficients of every row the table allows at once, against the definition in f64.
#[test]
fn every_term_is_its_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut table = TermTable::equation_9();
    for term in [3, 5, 8, 12, 16].map(Term::own) {
        table.push(term).unwrap();
    }
    let crossed = Term {
        own_order: 1,
        lateral_order: -2,
        theta_power: 1,
        multiplier: Multiplier::None,
    };
    let more = [
        Term::lateral(2),
        Term::lateral(4).with_theta(1),
        Term::own(2).with_theta(3),
        Term::own(0).with_theta(2),
        Term::own(0).with(Multiplier::Speed),
        Term::own(1).with(Multiplier::Temperature),
        Term::own(0).with(Multiplier::Direction),
        Term {
            own_order: 2,
            lateral_order: 3,
            ..Term::default()
        },
        crossed,
    ];
    more.into_iter().for_each(|term| table.push(term).unwrap());
    let mut model = ErrorModel::zero(table.clone());
    model.constants_m = [1e-6, -2e-6, 3e-6, 0.5e-6];
    for (term, rows) in table.iter().zip(model.coefficients.iter_mut()) {
        let unit = match term.multiplier {
            Multiplier::Speed => 1e-5,
            Multiplier::Temperature => 1e-7,
            _ => 5e-6 * 30.0_f32.powi(i32::from(term.theta_power)),
        };
        rows.iter_mut()
            .flatten()
            .for_each(|k| *k = unit * rng.random_range(-1.0..1.0));
    }
    let settings = Settings {
        model: Some(model.clone()),
        ..Settings::default()
    };
    let mut x = 0.0;
    let raws: Vec<_> = (0..3000)
        .map(|k| {
            x += 0.06 * (f64::from(k) * 0.01).sin();
            let half = 0.12 * (f64::from(k) * 0.013).cos();
            RawFrame {
                temperature_delta_k: 0.01 * k as f32 - 10.0,
                ..raw(at(x, 0.3 - 0.6 * x, half))
            }
        })
        .collect();
    for frame in run(&settings, raws) {
        for i in 0..SEGMENTS {
            let segment = &frame.segments[i];
            let e = f64::from(segment.calibrated.fraction_turns)
                - f64::from(segment.unmodified.fraction_turns);
            let expected = exact_error_m(&model, &frame, i);
            assert!(
                (e * PITCH_M - expected).abs() < 0.5e-9,
                "{i}: {} {expected}",
                e * PITCH_M
            );
        }
        assert_eq!(frame.status, Status::empty());
    }
}

/// The definition in docs/design.md, in f64, from the frame's unmodified outputs.
fn exact_error_m(model: &ErrorModel, frame: &Frame, i: usize) -> f64 {
    let g = Geometry::PAPER;
    let p = frame
        .segments
        .map(|s| f64::from(s.unmodified.teeth) + f64::from(s.unmodified.fraction_turns));
    let theta = 0.5 * (p[0] - p[2] + p[1] - p[3]) * PITCH_M / f64::from(g.span_m);
    let (x, y) = (0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]));
    let shift = f64::from(g.lateral_m) * theta / PITCH_M;
    let lateral = [y - shift, x + shift, y + shift, x - shift][i];
    let mut sum = f64::from(model.constants_m[i]);
    for (term, rows) in model.terms.iter().zip(&model.coefficients) {
        let angle =
            TAU * (f64::from(term.own_order) * p[i] + f64::from(term.lateral_order) * lateral);
        let factor = theta.powi(i32::from(term.theta_power))
            * f64::from(match term.multiplier {
                Multiplier::None => 1.0,
                Multiplier::Speed => frame.speed_m_s[i & 1],
                Multiplier::Temperature => frame.raw.temperature_delta_k,
                Multiplier::Direction => frame.direction[i & 1],
            });
        sum += factor * (f64::from(rows[i][0]) * angle.sin() + f64::from(rows[i][1]) * angle.cos());
    }
    sum
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

#[test]
fn both_entries_give_the_same_bits() {
    let config = StepConfig::build(&Settings::default()).unwrap();
    let (mut a, mut b) = (StepState::new(), StepState::new());
    for k in 0..1000 {
        let raw = raw(at(0.07 * f64::from(k), 0.01, 0.1));
        *b.raw_mut() = raw;
        assert_eq!(step(&config, &mut a, &raw), *isr_step(&config, &mut b));
    }
}

#[test]
fn settings_that_cannot_work_are_refused_by_name() {
    let refuse = |change: &dyn Fn(&mut Settings)| {
        let mut settings = Settings::default();
        change(&mut settings);
        StepConfig::build(&settings).unwrap_err()
    };
    let named = |change: &dyn Fn(&mut Settings)| match refuse(change) {
        ConfigError::Range { name, .. } => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(named(&|s| s.geometry.pitch_m = 1.016), "pitch_m");
    assert_eq!(named(&|s| s.geometry.span_m = f32::NAN), "span_m");
    assert_eq!(named(&|s| s.geometry.lever_m[1] = f32::INFINITY), "lever_m");
    assert_eq!(named(&|s| s.pairs[3].gain = 0.0), "gain");
    assert_eq!(named(&|s| s.rate_hz = 0.0), "rate_hz");
    assert_eq!(named(&|s| s.limits.slip_turns = 0.5), "slip_turns");
    assert_eq!(
        named(&|s| s.limits.beacon.sum_low_counts = 0),
        "beacon.sum_low_counts"
    );
    assert_eq!(
        refuse(&|s| s.limits.frozen_samples = 100),
        ConfigError::FrozenSamples(100)
    );
    let mut model = ErrorModel::zero(TermTable::equation_3());
    model.coefficients[2][1] = [4e-4, 2e-4];
    let error = refuse(&|s| s.model = Some(model.clone()));
    assert!(
        matches!(error, ConfigError::ModelSize { segment: 1, .. }),
        "{error:?}"
    );
    model.coefficients[2][1] = [f32::NAN, 0.0];
    let error = refuse(&|s| s.model = Some(model.clone()));
    assert_eq!(
        error.to_string(),
        "error model: segment 1: coefficient NaN of term Some(2) is not within ±1000"
    );
}

mod any_input {
    use super::*;
    use proptest::prelude::*;

    fn finite(frame: &Frame) -> bool {
        let pose = &frame.pose;
        let mut values = vec![
            pose.x.fraction_turns,
            pose.y.fraction_turns,
            pose.theta_x_rad,
            pose.theta_y_rad,
            pose.theta_rad,
            frame.parity_m,
            frame.tan_psi[0],
            frame.tan_psi[1],
            frame.raw.temperature_delta_k,
            frame.speed_m_s[0],
            frame.speed_m_s[1],
        ];
        for s in &frame.segments {
            let fractions = [s.unmodified.fraction_turns, s.calibrated.fraction_turns];
            values.extend(fractions.into_iter().chain([s.amplitude_counts]));
        }
        values.iter().all(|v| v.is_finite())
    }

    prop_compose! {
        fn any_raw()(quadrature_counts: [[i16; 2]; 4], electrode_counts: [i16; 4], temperature_delta_k: f32, fault: u32)
            -> RawFrame {
            let fault = Status::from_bits_truncate(fault & fault.rotate_left(7));
            RawFrame { quadrature_counts, electrode_counts, temperature_delta_k, fault }
        }
    }

    prop_compose! {
        fn any_term()(own_order in 0_u8..=16, lateral_order in -4_i8..=4, theta_power in 0_u8..=3, kind in 0_usize..4)
            -> Term {
            let kinds = [Multiplier::None, Multiplier::Speed, Multiplier::Temperature, Multiplier::Direction];
            Term { own_order, lateral_order, theta_power, multiplier: kinds[kind] }
        }
    }

    proptest! {
        #[test]
        fn no_input_gives_a_result_that_is_not_finite(
            raws in prop::collection::vec(any_raw(), 1..60),
            terms in prop::collection::vec(any_term(), 0..24),
            coefficients in prop::collection::vec(-1000.0_f32..1000.0, 192),
            gain in 0.1_f32..10.0,
            angle_rad in -1.0_f32..1.0,
            offset in -32768.0_f32..32768.0,
            scale in 0_i32..8,
        ) {
            let mut table = TermTable::default();
            for term in terms {
                let mut wider = table.clone();
                if wider.push(term).is_ok() && wider.validate().is_ok() {
                    table = wider;
                }
            }
            let mut model = ErrorModel::zero(table);
            let slots = model.coefficients.iter_mut().flatten().flatten();
            slots.zip(coefficients).for_each(|(slot, k)| *slot = k * 10.0_f32.powi(-scale));
            let pair = PairCorrection { offset_counts: [offset, -offset], gain, angle_rad };
            let mut settings = Settings { model: Some(model), pairs: [pair; 4], ..Settings::default() };
            if StepConfig::build(&settings).is_err() {
                // Too large for the dense part: leave only what depends on more than phases.
                let model = settings.model.as_mut().unwrap();
                let terms: Vec<_> = model.terms.iter().copied().collect();
                for (term, rows) in terms.iter().zip(model.coefficients.iter_mut()) {
                    if term.theta_power == 0 && term.multiplier == Multiplier::None {
                        *rows = Default::default();
                    }
                }
            }
            let config = StepConfig::build(&settings).unwrap();
            let mut state = StepState::new();
            for raw in raws {
                let frame = step(&config, &mut state, &raw);
                prop_assert!(finite(&frame), "{frame:?}");
            }
        }
    }

    #[test]
    fn counts_may_wrap() {
        let config = StepConfig::build(&Settings {
            limits: Limits::default(),
            ..Settings::default()
        })
        .unwrap();
        let mut state = StepState::new();
        step(&config, &mut state, &raw([0.4; 4]));
        state.set_teeth([i32::MAX, i32::MIN, i32::MIN, i32::MAX]);
        let frame = step(&config, &mut state, &raw([0.6; 4]));
        assert!(finite(&frame));
        assert_eq!(frame.segments[0].unmodified.teeth, i32::MIN);
    }
}
