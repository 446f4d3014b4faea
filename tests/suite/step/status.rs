//! Every status bit, and what a frame holds while it is set.

use super::{PITCH_M, at, calibrated, raw, run};
use courier_sensor::frame::{RawFrame, SEGMENTS, Status};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn a_jump_is_a_slip_that_stays_until_cleared() {
    let config = StepConfig::build(&calibrated()).unwrap();
    for i in 0..SEGMENTS {
        for jump in [0.21, 0.5, -0.3, 0.79] {
            let mut state = StepState::new();
            let mut p = [0.1; SEGMENTS];
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
fn a_channel_that_stands_beside_one_that_changes_is_at_a_rail() {
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
        let expected = stuck.map_or(Status::empty(), |(i, _)| {
            Status::from_bits_retain(Status::RAIL_1.bits() << i)
        });
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
