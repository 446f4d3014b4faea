//! A reference with an error of its own: periodic, stuck, late, or logged with few digits. The sensor is not blamed.

use super::field::{courier, diagnose};
use recording::Recording;
use std::f64::consts::TAU;

fn moved(of: &Recording, error_m: impl Fn(f64) -> f64) -> Recording {
    of.with_rows(|_, row| {
        for axis in 0..2 {
            row.reference[axis] = row.reference[axis].map(|x| x + error_m(x));
        }
        true
    })
}

#[test]
fn a_periodic_reference() {
    let sound = courier(34, &[], true);
    assert_eq!(diagnose(&sound).verdict(), "no_gap");
    let pitch_m = sound.meta.geometry.pitch_m;
    for order in [0.37, 1.0, 3.0, 8.0, 50.0] {
        let wave = |x: f64| 2.0e-6 * (TAU * order * x / pitch_m + 0.3).sin();
        let told = diagnose(&moved(&sound, wave));
        assert_eq!(
            told.verdict(),
            "unknown",
            "order {order}: {}",
            told.answer()
        );
    }
}

#[test]
fn a_coarse_stuck_or_late_reference() {
    let sound = courier(34, &[], true);
    let coarse = moved(&sound, |x| (x * 1e5).round() * 1e-5 - x);
    let stuck = moved(&sound, |x| 0.05 - x);
    let late = sound.with_rows(|i, row| {
        row.reference = sound.samples.row(i.saturating_sub(1)).reference;
        true
    });
    for of in [coarse, stuck, late] {
        diagnose(&of).names_only(&[]);
    }
}

/// One segment cannot tell its own orders from the reference's: said so, and not for certain.
#[test]
fn one_segment_alone() {
    let sound = courier(34, &[], true);
    let alone = sound.with_rows(|_, row| {
        for s in 1..4 {
            (row.quadrature_counts[s], row.teeth[s]) = (None, None);
        }
        true
    });
    assert_eq!(diagnose(&alone).verdict(), "no_gap");
    let pitch_m = sound.meta.geometry.pitch_m;
    let told = diagnose(&moved(&alone, |x| 2.0e-6 * (TAU * 3.0 * x / pitch_m).sin()));
    told.names_only(&["extra_harmonics"]);
    for effect in told.answer()["effects"].as_array().unwrap() {
        assert!(effect["probability"].as_f64().unwrap() <= 0.5);
        assert!(
            told.answer()["notes"]
                .to_string()
                .contains("reference itself")
        );
    }
}
