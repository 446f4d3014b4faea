//! Pairs whose offsets wander faster than coarse knots over the recording follow, beside another effect and on another recording.

mod rig;

use diagnosis::{Answer, Options, diagnose_fully};
use recording::Recording;
use std::f64::consts::TAU;

/// Largest offset of a pair, of its amplitude.
const OFFSET: f64 = 0.02;
/// Periods over the recording of one segment's offset; each further segment has one more.
const PERIODS: f64 = 12.0;

/// A recording of which only so many samples of the long runs are left, and whose pairs wander from time to time.
fn wandering(effects: &[(&str, f64)], every: usize) -> Recording {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let mut out = rig::record(24, effects, &options).0;
    let amplitude = out.meta.electronics.amplitude_counts.expect("counts");
    let whole = std::mem::take(&mut out.samples);
    let last_s = whole.t_s().last().copied().expect("samples");
    for index in 0..whole.len() {
        let mut row = whole.row(index);
        let long = ["scatter", "beacon"].contains(&row.run);
        if long && index % every > 0 {
            continue;
        }
        for segment in 0..4 {
            let [sine, cosine] = row.quadrature_counts[segment].expect("counts");
            let turns = (PERIODS + segment as f64) * row.t_s / last_s;
            let (s, c) = (TAU * turns).sin_cos();
            let moved = [
                sine + OFFSET * amplitude * s,
                cosine + OFFSET * amplitude * c,
            ]
            .map(f64::round);
            // Where the phase goes past half a turn the tooth count follows.
            let past = (sine.atan2(cosine) - moved[0].atan2(moved[1])) / TAU;
            row.quadrature_counts[segment] = Some(moved);
            row.teeth[segment] = row.teeth[segment].map(|n| n + past.round() as i32);
        }
        out.samples.push(&row);
    }
    out
}

fn answer(recording: &Recording) -> (Vec<String>, Answer) {
    let answer = diagnose_fully(recording, "rig", &Options::default());
    let effects = answer.diagnosis.effects.iter();
    (effects.map(|e| e.name.clone()).collect(), answer)
}

#[test]
fn what_is_beside_a_quick_wander_is_named() {
    for other in ["psd_nonlinearity", "lateral_dependence"] {
        let (mut names, answer) = answer(&wandering(&[(other, 2.0e-6)], 1));
        names.sort_unstable();
        let verdict = answer.diagnosis.verdict;
        let mut wanted = [other, "quadrature_drift"];
        wanted.sort_unstable();
        assert_eq!(names, wanted, "{verdict:?}");
    }
}

/// Most samples come in a small part of the time, in which the pairs hardly move. On another recording they stand elsewhere: what
/// is expected there is what the wander does over all of its time, and the other effect is known beside it.
#[test]
fn a_wander_is_foretold_from_the_whole_of_its_time() {
    let recording = wandering(&[("lateral_dependence", 1.0e-6)], 6);
    let (names, answer) = answer(&recording);
    assert!(names.contains(&"quadrature_drift".into()), "{names:?}");
    let channels = &answer.diagnosis.held_out.channels;
    let parity = channels.iter().find(|c| c.channel == "g_p").expect("g_p");
    // Each pair's offsets turn by a circle: its phase is off by the offset times the sine of what is between the two.
    let pair_m = OFFSET / 2.0_f64.sqrt() * recording.meta.geometry.pitch_m / TAU;
    let wanted_m = parity.floor_rms_m.hypot(2.0 * pair_m);
    let ratio = parity.after_rms_m / wanted_m;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}
