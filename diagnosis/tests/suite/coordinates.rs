//! A pair's offset that follows the temperature or the clock.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use recording::Recording;
use specimens::rig;
use std::f64::consts::TAU;

/// Offset of one sine at the warmest, of the amplitude: 0.5 % is usual and 6 % has been seen (lib_sincos_enc).
const OFFSET: f64 = 0.02;
/// Between the coldest and the warmest, K.
const RANGE_K: f64 = 15.0;
/// The coldest, °C.
const COLDEST_C: f64 = 22.0;

/// Courses from 0 to 1 over the time from 0 to 1.
const WARMS: fn(f64) -> f64 = |t| (1.0 - (-2.0 * t).exp()) / (1.0 - (-2.0_f64).exp());
const COMES_BACK: fn(f64) -> f64 = |t| 0.5 - 0.5 * (2.4 * TAU * t).cos();

/// A courier of which one segment's sine has an offset in proportion to a course, with what its thermometer tells.
fn shifted(course: fn(f64) -> f64, thermometer: bool) -> Recording {
    let options = rig::Options {
        samples: 3000,
        counts: true,
        ..rig::Options::default()
    };
    let mut out = rig::record_as(31, 31, &[], &options).0;
    let amplitude = out.meta.electronics.amplitude_counts.expect("counts");
    let whole = std::mem::take(&mut out.samples);
    let last_s = whole.t_s().last().copied().expect("samples");
    for index in 0..whole.len() {
        let mut row = whole.row(index);
        let now = course(row.t_s / last_s);
        let [sine, cosine] = row.quadrature_counts[0].expect("counts");
        let moved = [(sine + amplitude * OFFSET * now).round(), cosine];
        // Where the phase goes past half a turn the tooth count follows.
        let past = (sine.atan2(cosine) - moved[0].atan2(moved[1])) / TAU;
        row.quadrature_counts[0] = Some(moved);
        row.teeth[0] = row.teeth[0].map(|n| n + past.round() as i32);
        row.temperature_c = thermometer.then(|| ((COLDEST_C + RANGE_K * now) * 1e3).round() / 1e3);
        out.samples.push(&row);
    }
    out
}

fn answer(recording: &Recording) -> Diagnosis {
    diagnose(recording, "rig", &Options::default())
}

fn names(answer: &Diagnosis) -> Vec<&str> {
    answer.effects.iter().map(|e| e.name.as_str()).collect()
}

/// Both at once, each as likely as to be worth a mention.
fn is_either(answer: &Diagnosis, wanted: [&str; 2]) -> bool {
    let [one] = &answer.effects[..] else {
        return false;
    };
    let mut both = vec![one.name.as_str()];
    both.extend(one.aliases.iter().map(String::as_str));
    both.sort_unstable();
    answer.verdict == Verdict::Alias && both == wanted && one.break_alias.is_some()
}

#[test]
fn an_offset_that_follows_a_temperature_which_comes_back_is_named_by_it() {
    let answer = answer(&shifted(COMES_BACK, true));
    assert_eq!(answer.verdict, Verdict::Named, "{:?}", names(&answer));
    assert_eq!(names(&answer), ["thermal_drift"]);
    assert_eq!(answer.effects[0].aliases, [""; 0]);
}

#[test]
fn where_the_temperature_only_rises_or_is_not_logged_it_is_either() {
    for recording in [shifted(WARMS, true), shifted(COMES_BACK, false)] {
        let answer = answer(&recording);
        assert!(
            is_either(&answer, ["quadrature_drift", "thermal_drift"]),
            "{:?}: {:?}",
            answer.verdict,
            answer.effects
        );
    }
}
