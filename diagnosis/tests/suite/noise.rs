//! What is noise, what is none though it is as rough, and what is seen beneath noise.

use crate::confusion::{four_segments, names, pair, sorted};
use diagnosis::{Options, Verdict, diagnose, diagnose_fully};
use recording::{Recording, Samples};
use specimens::rig;

/// Amplifiers switch, now and then, and couple into one segment's pair for one sample: most strikes lie within what the noise of
/// four segments hides, a few of them stand out.
fn struck(seed: u64, share: f64, over_noise: f64) -> Recording {
    let quiet = four_segments(seed, &[]);
    let noise = quiet.meta.electronics.quadrature_noise_counts;
    let strength = over_noise * noise.expect("a stated noise");
    let mut dice = rig::Dice(seed);
    let mut samples = Samples::default();
    for i in 0..quiet.samples.len() {
        let mut row = quiet.samples.row(i);
        if dice.unit() < share {
            let pair = row.quadrature_counts[2].expect("a pair");
            let now = strength * (0.4 * dice.normal()).exp();
            let hit = pair.map(|value| (value + now * dice.normal()).round());
            let turns = |[sine, cosine]: [f64; 2]| sine.atan2(cosine) / std::f64::consts::TAU;
            row.quadrature_counts[2] = Some(hit);
            row.teeth[2] = row.teeth[2].map(|n| n + (turns(pair) - turns(hit)).round() as i32);
        }
        samples.push(&row);
    }
    Recording { samples, ..quiet }
}

/// What is left of strikes too small to stand out raises the mean square as noise does: it is none, since most samples are as
/// quiet as is stated.
#[test]
fn bursts_too_small_to_stand_out_are_no_noise() {
    let recording = struck(25, 0.05, 7.0);
    let d = diagnose(&recording, "rig", &Options::default());
    assert_eq!(names(&d), ["outlier_bursts"], "{:?}", d.verdict);
    assert!(d.held_out.whitened_after > 1.1, "{:?}", d.held_out);
    let answer = diagnose_fully(&recording, "rig", &Options::default());
    assert_eq!(names(&answer.diagnosis), ["outlier_bursts"]);
}

/// A vibration of some three samples a turn is as rough as noise from sample to sample.
#[test]
fn a_fast_vibration_is_no_noise() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let still = rig::record(41, &[], &options).0;
    let shaken = rig::shake::shaken(&still, 0.31, |_| 5.0e-4);
    let d = diagnose(&shaken, "rig", &Options::default());
    assert_eq!(names(&d), ["beacon_vibration"], "{:?}", d.verdict);
    assert!(d.held_out.whitened_before > 1.2, "{:?}", d.held_out);
}

/// The same of a segment, which no effect owns: the line has a place.
#[test]
fn a_fast_hum_is_no_noise() {
    let options = rig::Options {
        samples: 6000,
        counts: false,
        beacon: false,
        ..rig::Options::default()
    };
    let still = rig::record(41, &[], &options).0;
    let d = diagnose(
        &rig::shake::hummed(&still, 0.31, 1.0e-6),
        "rig",
        &Options::default(),
    );
    assert_eq!(d.verdict, Verdict::Unknown, "{:?}", names(&d));
    assert_eq!(d.place[0].coordinate, "frequency", "{:?}", d.place);
}

/// A field of displaced teeth beneath noise of thirteen times the stated one.
pub fn field_beneath_noise() -> Recording {
    four_segments(24, &[("tooth_variation", 2.0e-6), ("excess_noise", 1.5e-6)])
}

/// Noise is what neighbours do not share; what they share beyond it is the field's.
#[test]
fn a_field_under_noise_is_seen() {
    let d = diagnose(&field_beneath_noise(), "rig", &Options::default());
    assert_eq!(
        sorted(&d),
        ["excess_noise", "tooth_variation"],
        "{:?}",
        d.verdict
    );
}

/// Noise of thirty times what is stated; the lag beneath it is a thirtieth of the squares.
fn lag_beneath_noise() -> Recording {
    let effects = [("excess_noise", 1.807e-6), ("velocity_lag", 1.886e-6)];
    pair(4_036_594_875_922_131, effects).recorded(0)
}

/// The noise is measured anew, by the stated one, each time that something else is found beside it.
#[test]
fn what_heavy_noise_hides_is_named_beside_it() {
    let d = diagnose(&lag_beneath_noise(), "two", &Options::default());
    assert_eq!(sorted(&d), ["excess_noise", "velocity_lag"]);
}
