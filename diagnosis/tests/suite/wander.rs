//! Pairs whose offsets wander faster than coarse knots over the recording follow, beside another effect and on another recording.

use specimens::rig;

use diagnosis::data::prepare::prepare;
use diagnosis::design::assembly::{DesignOptions, assemble};
use diagnosis::linearization::relinearized::RelinearizedFit;
use diagnosis::{Answer, Options, check, diagnose_fully};
use recording::Recording;
use specimens::{Case, Conditions};
use std::f64::consts::TAU;

/// Largest offset of a pair, of its amplitude.
const OFFSET: f64 = 0.02;
/// Periods over the recording of one segment's offset; each further segment has one more.
const PERIODS: f64 = 12.0;
/// Fewer, which coarse knots follow.
const SLOW: f64 = 2.0;

/// How the pairs wander.
struct Course {
    periods: f64,
    /// Where the wander is at the first sample, turns.
    from_turns: f64,
    /// What the offsets turn about, of the amplitude.
    point: f64,
    /// Segments whose pairs wander.
    of: [bool; 4],
}

impl Course {
    fn first(periods: f64) -> Self {
        Self {
            periods,
            from_turns: 0.0,
            point: 0.0,
            of: [true; 4],
        }
    }

    /// Offsets of a segment's pair, of the amplitude.
    fn offsets(&self, segment: usize, progress: f64) -> [f64; 2] {
        if !self.of[segment] {
            return [0.0; 2];
        }
        let turns = self.from_turns + (self.periods + segment as f64) * progress;
        let (sine, cosine) = (TAU * turns).sin_cos();
        [
            self.point + OFFSET * sine,
            OFFSET.mul_add(cosine, -self.point),
        ]
    }
}

fn options(counts: bool) -> rig::Options {
    rig::Options {
        samples: 6000,
        counts,
        ..rig::Options::default()
    }
}

/// A recording of one courier whose pairs wander from time to time.
fn wandering(motion: u64, effects: &[(&str, f64)], course: &Course) -> Recording {
    let mut out = rig::record_as(24, motion, effects, &options(true)).0;
    let amplitude = out.meta.electronics.amplitude_counts.expect("counts");
    let whole = std::mem::take(&mut out.samples);
    let last_s = whole.t_s().last().copied().expect("samples");
    for index in 0..whole.len() {
        let mut row = whole.row(index);
        for segment in 0..4 {
            let [sine, cosine] = row.quadrature_counts[segment].expect("counts");
            let [s, c] = course.offsets(segment, row.t_s / last_s);
            let moved = [sine + amplitude * s, cosine + amplitude * c].map(f64::round);
            // Where the phase goes past half a turn the tooth count follows.
            let past = (sine.atan2(cosine) - moved[0].atan2(moved[1])) / TAU;
            row.quadrature_counts[segment] = Some(moved);
            row.teeth[segment] = row.teeth[segment].map(|n| n + past.round() as i32);
        }
        out.samples.push(&row);
    }
    out
}

/// The same where the segments' positions were written and not their counts.
fn as_positions(recording: &Recording) -> Recording {
    let mut out = rig::record_as(24, 24, &[], &options(false)).0;
    out.samples = Default::default();
    for index in 0..recording.samples.len() {
        let mut row = recording.samples.row(index);
        for segment in 0..4 {
            let pair = row.quadrature_counts[segment].take().expect("counts");
            let teeth = row.teeth[segment].take().expect("teeth");
            let pitch_m = recording.meta.geometry.pitch_m;
            row.position_m[segment] = Some(recording::unmodified_m(teeth, pair, pitch_m));
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
        let recording = wandering(24, &[(other, 2.0e-6)], &Course::first(PERIODS));
        let (mut names, answer) = answer(&recording);
        names.sort_unstable();
        let verdict = answer.diagnosis.verdict;
        let mut wanted = [other, "quadrature_drift"];
        wanted.sort_unstable();
        assert_eq!(names, wanted, "{verdict:?}");
    }
}

/// On another day the pairs turn about other offsets by another course: their amplitudes show it there as they did here.
#[test]
fn a_wander_is_followed_by_the_counts_of_another_recording() {
    let effects = [("lateral_dependence", 1.0e-6)];
    let (_, answer) = answer(&wandering(24, &effects, &Course::first(SLOW)));
    let model = answer.model.expect("a model");
    let elsewhere = Course {
        periods: 3.3,
        from_turns: 0.4,
        point: 0.03,
        ..Course::first(SLOW)
    };
    let came = check(&model, &wandering(1024, &effects, &elsewhere)).expect("residuals");
    let claimed = model.claimed.whitened_after;
    assert!(came.whitened_before > 3.0, "{}", came.whitened_before);
    assert!(claimed < 1.1, "{claimed}");
    let ratio = came.whitened_after / claimed;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Positions do not show how the pairs stand on another recording: what is expected there is what the wander does over all of its time.
#[test]
fn a_wander_without_counts_is_foretold_from_the_whole_of_its_time() {
    let recording = as_positions(&wandering(24, &[], &Course::first(SLOW)));
    let (names, answer) = answer(&recording);
    assert!(
        names.contains(&"quadrature_drift".into()),
        "{names:?} {:?}",
        answer.diagnosis
    );
    let channels = &answer.diagnosis.held_out.channels;
    let parity = channels.iter().find(|c| c.channel == "g_p").expect("g_p");
    // Each pair's offsets turn by a circle: its phase is off by the offset times the sine of what is between the two.
    let pair_m = OFFSET / 2.0_f64.sqrt() * recording.meta.geometry.pitch_m / TAU;
    let wanted_m = parity.floor_rms_m.hypot(2.0 * pair_m);
    let ratio = parity.after_rms_m / wanted_m;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Of one pair: the others' courses, which are as many unknowns and of which nothing shows, come to next to nothing.
#[test]
fn the_wander_of_one_pair_without_counts_is_put_down_to_that_pair() {
    for segment in [1, 2] {
        let course = Course {
            of: std::array::from_fn(|s| s == segment),
            ..Course::first(0.3)
        };
        let recording = as_positions(&wandering(24, &[], &course));
        let (names, answer) = answer(&recording);
        let held_out = answer.diagnosis.held_out;
        assert_eq!(names, ["quadrature_drift"], "{held_out:?}");
        let amounts = &answer.model.expect("a model").effects[0].amounts;
        let square = |own: bool| -> f64 {
            let of = |name: &str| name.ends_with(&format!("segment {}", segment + 1));
            let these = amounts.iter().filter(|a| of(&a.name) == own);
            these.map(|a| a.value * a.value).sum()
        };
        let share = square(false) / square(true);
        assert!(share < 0.01, "{share}");
    }
}

/// What a set of effects leaves of a recording, over the noise, where each is fitted about all of them.
fn left_by(recording: &Recording, names: &[&str]) -> f64 {
    let prepared = prepare(recording).unwrap();
    let start = prepared.point();
    let names: Vec<String> = names.iter().map(|name| (*name).into()).collect();
    let design_options = DesignOptions {
        only: Some(&names),
        ..DesignOptions::default()
    };
    let design = assemble(&prepared, &Options::default(), &start, design_options);
    let fit = RelinearizedFit::new(&design.linearized, start, &names);
    fit.residuals().white_rms()
}

/// A channel at its rail stays there whatever its offset does, and tells no amplitude: taken for one, it hid the wander of the pair. Of two
/// hundred squares over the noise less than the noise is left: the pair's figure is told from readings that wander.
#[test]
fn a_wander_of_pairs_that_are_cut_is_told() {
    let whole = wandering(24, &[], &Course::first(SLOW));
    let amplitude = whole.meta.electronics.amplitude_counts.expect("counts");
    let rail = (0.85 * amplitude).round();
    let cut = whole.with_rows(|_, row| {
        for pair in row.quadrature_counts.iter_mut().skip(1).flatten() {
            *pair = pair.map(|value| value.clamp(-rail, rail));
        }
        true
    });
    let beyond_noise = |names: &[&str]| left_by(&cut, names).powi(2) - 1.0;
    let [whole, left] =
        [&["adc_clipping"][..], &["adc_clipping", "quadrature_drift"]].map(beyond_noise);
    assert!(whole > 100.0 && left < 1.0, "{left} of {whole}");
}

/// Offsets that change with the place are seen beside those that wander.
#[test]
fn offsets_over_the_place_are_seen_beside_a_wander() {
    let mut case = Case::draw(21, 6058, Conditions::Drawn);
    let shows = |case: &Case| {
        let amplitudes = prepare(&case.recorded(0)).unwrap().amplitudes;
        let some = |list: &[Vec<f64>; 4]| list.iter().any(|one| !one.is_empty());
        let wanders = amplitudes.pair_course.iter().any(|one| !one.is_empty());
        [wanders, some(&amplitudes.by_offsets)]
    };
    assert_eq!(shows(&case), [true, true], "{:?}", case.effects);
    case.effects.retain(|e| e.name == "quadrature_drift");
    assert_eq!(shows(&case), [true, false], "{:?}", case.effects);
}

/// Sweeps of seconds between poses over a minute: a change of the whole amplitude over the time follows the noise there, and beside it the wander was told
/// so badly that a fifth of the squares was left beyond the noise. What is left of this courier is the noise that it has.
#[test]
fn a_wander_between_runs_far_apart_leaves_the_noise_that_is_there() {
    let case = Case::draw(12, 6058, Conditions::Drawn);
    let size_m = |name: &str| {
        let mut effects = case.effects.iter();
        effects.find(|e| e.name == name).expect("drawn").size_m
    };
    assert!(size_m("quadrature_drift") > 1.0e-6);
    let recording = case.recorded(0);
    let (electronics, pitch_m) = (recording.meta.electronics, recording.meta.geometry.pitch_m);
    let noise =
        electronics.quadrature_noise_counts.unwrap() / electronics.amplitude_counts.unwrap();
    let stated_m = noise * pitch_m / TAU;
    let is_there = 1.0_f64.hypot(size_m("excess_noise") / stated_m);
    let left = left_by(&recording, &["quadrature_drift"]) / is_there;
    assert!((left - 1.0).abs() < 0.03, "{left} times the noise");
}
