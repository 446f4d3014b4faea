//! Clips of one end: rails that an offset has pushed the wave against. Rails that are soft, and harmonics that are no clip.
use specimens::rig;

use diagnosis::{Answer, Diagnosis, Options, check, diagnose_fully};
use effects::sensor::Clip;
use recording::{Recording, Row};

fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

/// A recording of the rig with its rows changed.
fn changed(recording: &Recording, change: impl Fn(&mut Row)) -> Recording {
    recording.with_rows(|_, row| {
        change(row);
        true
    })
}

/// Rails of sine and cosine of segments 1 and 4, of the amplitude: one end, one channel at both ends but not alike.
const RAILS: [(usize, [[f64; 2]; 2]); 2] = [
    (0, [[-2.0, 0.86], [-2.0, 2.0]]),
    (3, [[-2.0, 2.0], [-0.90, 0.84]]),
];

fn cut(recording: &Recording) -> Recording {
    let amplitude = recording.meta.electronics.amplitude_counts.unwrap();
    changed(recording, |row| {
        for (s, rails) in RAILS {
            let between = |channel: usize, value: f64| {
                let [low, high] = rails[channel].map(|r| (r * amplitude).round());
                value.clamp(low, high)
            };
            row.quadrature_counts[s] =
                row.quadrature_counts[s].map(|p| [between(0, p[0]), between(1, p[1])]);
        }
    })
}

#[test]
fn a_clip_of_one_end_is_named_and_its_ends_are_told() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let recording = cut(&rig::record(31, &[], &options).0);
    let Answer {
        diagnosis: d,
        model,
        ..
    } = diagnose_fully(&recording, "one end", &Options::default());
    assert_eq!(names(&d), ["adc_clipping"], "{:?}", d.verdict);
    assert!(d.held_out.whitened_after < 1.1, "{:?}", d.held_out);
    // The model carries the ends: those that cut within the pair's own gain of what was drawn, the others open.
    let found = &model.expect("a model").inputs.clip;
    for (s, rails) in RAILS {
        let told = found[s].expect("a clip").rails;
        for (told, drawn) in told.as_flattened().iter().zip(rails.as_flattened()) {
            if drawn.abs() > 1.0 {
                assert_eq!(told.abs(), Clip::OPEN, "segment {}: {told}", s + 1);
            } else {
                assert!((told / drawn - 1.0).abs() < 0.01, "{told} for {drawn}");
            }
        }
    }
    assert_eq!([found[1], found[2]], [None; 2]);
}

/// Rails below the amplitude over the root of two: at the corners of such a square figure all phases read alike.
#[test]
fn corners_at_which_both_channels_are_cut_are_left_out() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let pair = |seed: u64, motion: u64| {
        let whole = rig::record_as(seed, motion, &[], &options).0;
        let rail = (0.64 * whole.meta.electronics.amplitude_counts.unwrap()).round();
        changed(&whole, |row| {
            for pair in row.quadrature_counts.iter_mut().take(3).flatten() {
                *pair = pair.map(|value| value.clamp(-rail, rail));
            }
        })
    };
    let (first, second) = (pair(33, 33), pair(33, 1033));
    let Answer {
        diagnosis: d,
        model,
        ..
    } = diagnose_fully(&first, "corners", &Options::default());
    assert_eq!(names(&d), ["adc_clipping"], "{:?}", d.verdict);
    let claimed = d.held_out.whitened_after;
    assert!(claimed < 1.1, "{claimed}");
    assert!(
        d.notes.iter().any(|n| n.contains("stand at their rails")),
        "{:?}",
        d.notes
    );
    let came = check(&model.expect("a model"), &second).expect("residuals");
    let ratio = came.whitened_after / claimed;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Three amplifiers that give way before their rails, none of them of the form that the sensor's side knows but in its limit: a
/// differential pair, one whose slope falls evenly to zero, an arctangent.
pub const AMPLIFIERS: [(&str, fn(f64) -> f64); 3] = [
    ("tanh", |v| 0.75 * (v / 0.75).tanh()),
    ("even", |v| {
        let over = (v.abs() - 0.65).clamp(0.0, 0.3);
        v.signum() * (v.abs().min(0.95) - over * over / 0.6)
    }),
    ("arctangent", |v| (1.1 * v).atan() / 1.1),
];

/// A courier of the independent simulator, all of whose pairs go through an amplifier.
pub fn saturated(amplifier: fn(f64) -> f64) -> recording::Recording {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let plain = rig::record(33, &[], &options).0;
    let amplitude = plain.meta.electronics.amplitude_counts.unwrap();
    changed(&plain, |row| {
        for pair in row.quadrature_counts.iter_mut().flatten() {
            *pair = pair.map(|v| (amplitude * amplifier(v / amplitude)).round());
        }
    })
}

#[test]
fn what_saturates_softly_is_no_harmonic() {
    are_clips(&AMPLIFIERS[..1]);
}

#[test]
#[ignore = "nightly: half a minute"]
fn what_saturates_softly_in_other_ways_is_no_harmonic() {
    are_clips(&AMPLIFIERS[1..]);
}

fn are_clips(amplifiers: &[(&str, fn(f64) -> f64)]) {
    for &(name, amplifier) in amplifiers {
        let recording = saturated(amplifier);
        let d = diagnose_fully(&recording, name, &Options::default()).diagnosis;
        assert_eq!(names(&d), ["adc_clipping"], "{name}: {:?}", d.verdict);
        assert!(
            d.held_out.whitened_before > 1.5 && d.held_out.whitened_after < 1.1,
            "{name}: {:?}",
            d.held_out
        );
    }
}

/// Orders that turn the pair along its circle leave the circle whole: no clip is seen in it.
#[test]
fn harmonics_bend_no_figure() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let recording = rig::record(34, &[("extra_harmonics", 2.0e-6)], &options).0;
    let answer = diagnose_fully(&recording, "harmonics", &Options::default());
    assert_eq!(names(&answer.diagnosis), ["extra_harmonics"]);
    assert_eq!(answer.model.expect("a model").inputs.clip, [None; 4]);
}

/// A pair whose gain is far too high stands at some rail all round, and nothing but its corners tells how far its waves would go.
#[test]
fn a_pair_that_is_nowhere_whole_is_told_by_its_corners() {
    const GAIN: f64 = 1.5;
    const RAIL: f64 = 0.95;
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let recording = rig::record(31, &[], &options).0;
    let amplitude = recording.meta.electronics.amplitude_counts.unwrap();
    let rail = (RAIL * amplitude).round();
    let recording = changed(&recording, |row| {
        let between = |value: f64| (GAIN * value).round().clamp(-rail, rail);
        row.quadrature_counts[0] = row.quadrature_counts[0].map(|p| p.map(between));
    });
    let Answer {
        diagnosis: d,
        model,
        ..
    } = diagnose_fully(&recording, "hot", &Options::default());
    assert_eq!(names(&d), ["adc_clipping"], "{:?}", d.verdict);
    let clip = model.unwrap().inputs.clip[0].expect("a clip");
    for rail in clip.rails.as_flattened() {
        // Poses fall unevenly over the turn: that moves the share of corners by some hundredths, and the rail by as much.
        assert!((rail.abs() / (RAIL / GAIN) - 1.0).abs() < 0.05, "{rail}");
    }
}
