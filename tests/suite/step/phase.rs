//! From counts to phase and amplitude: what the documentation quotes.

use super::{BEACON, PITCH_M, at, calibrated, pair, raw, run};
use courier_sensor::frame::RawFrame;
use courier_sensor::quadrature::PairCorrection;
use courier_sensor::settings::Settings;
use std::f64::consts::TAU;

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
