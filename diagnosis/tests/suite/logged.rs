//! What follows a logged column and is no effect of the catalogue: where it lies, by how much, and how far a correction without a name gets.

use crate::shared::of_one_segment;
use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use recording::{Electronics, Logged, Recording, Row, Samples};
use specimens::rig::Dice;
use std::f64::consts::TAU;

/// Tooth pitch, m.
const PITCH_M: f64 = 1.0e-3;
/// Samples.
const COUNT: usize = 6000;
/// Noise of the position, m rms.
const NOISE_M: f64 = 0.1e-6;

/// What the humidity does in percent: it comes and goes.
fn humidity(t_s: f64) -> f64 {
    40.0 + 5.0 * (0.9 * t_s).sin() + 3.0 * (2.3 * t_s + 1.0).cos()
}

/// A segment beside a reference, to and fro over ten pitches; `error_m` of the phase of its tooth and the humidity is added to its output.
fn recording(seed: u64, error_m: impl Fn(f64, f64) -> f64) -> Recording {
    let mut dice = Dice(seed);
    let mut samples = Samples::default();
    let mut values = Vec::new();
    for k in 0..COUNT {
        let t_s = k as f64 * 2.0e-3;
        let reference_m = 5.0 * PITCH_M * (1.0 - (1.3 * t_s).cos());
        let phase = TAU * reference_m / PITCH_M;
        let rh = humidity(t_s);
        let known_m = 3.0e-6 * phase.sin();
        let noise_m = NOISE_M * dice.normal();
        samples.push(&Row {
            t_s,
            run: "sweep",
            position_m: [
                Some(reference_m + known_m + error_m(phase, rh) + noise_m),
                None,
                None,
                None,
            ],
            reference: [Some(reference_m), None, None],
            ..Row::default()
        });
        values.push(rh);
    }
    samples.log(Logged {
        name: "aux_rh".into(),
        values,
    });
    let electronics = Electronics {
        position_noise_m: Some(NOISE_M),
        ..Electronics::default()
    };
    of_one_segment(PITCH_M, electronics, samples)
}

fn of(recording: &Recording) -> Diagnosis {
    diagnose(recording, "rig", &Options::default())
}

/// An answer is `unknown`, over the coordinate, and tells the slope to within four of its deviations; its correction leaves nearly nothing.
fn unknown_with_slope(answer: &Diagnosis, coordinate: &str, over_teeth: bool, per_percent_m: f64) {
    assert_eq!(answer.verdict, Verdict::Unknown, "{:?}", answer.effects);
    let left = &answer.unexplained;
    assert_eq!(left.place[0].coordinate, coordinate, "{:?}", left.place);
    let slope = left.follows.iter().find(|f| f.over_teeth == over_teeth);
    let slope = slope.unwrap_or_else(|| panic!("a slope, found {:?}", left.follows));
    assert_eq!(
        (slope.column.as_str(), slope.of.as_str()),
        ("aux_rh", "segment_1")
    );
    let off = (slope.per_unit_m - per_percent_m).abs();
    assert!(
        off < 4.0 * slope.deviation_m,
        "{slope:?}, {per_percent_m} wanted"
    );
    assert!(slope.deviation_m < 0.05 * per_percent_m, "{slope:?}");
    let correction = left.correction.as_ref().expect("a correction");
    assert!(correction.coordinates.iter().any(|c| c == coordinate));
    assert!(correction.whitened_after < 1.1, "{correction:?}");
    assert!(answer.held_out.whitened_after > 2.0);
}

#[test]
fn an_output_that_moves_with_the_humidity_lies_over_it() {
    let answer = of(&recording(1, |_, rh| 0.1e-6 * (rh - 40.0)));
    unknown_with_slope(&answer, "aux_rh", false, 0.1e-6);
}

/// Order two over a tooth, which no stray field makes.
#[test]
fn an_error_over_a_tooth_that_grows_with_the_humidity_lies_over_both() {
    let answer = of(&recording(2, |phase, rh| {
        0.1e-6 * (rh - 40.0) * (2.0 * phase).sin()
    }));
    unknown_with_slope(
        &answer,
        "aux_rh and own tooth phase",
        true,
        0.1e-6 / 2.0_f64.sqrt(),
    );
}

#[test]
fn a_column_beside_an_effect_that_it_has_no_part_in_is_not_told() {
    let speed = |t_s: f64| 6.5 * PITCH_M * (1.3 * t_s).sin();
    let mut late = recording(3, |_, _| 0.0);
    let whole = std::mem::take(&mut late.samples);
    for i in 0..whole.len() {
        let mut row = whole.row(i);
        row.position_m[0] = row.position_m[0].map(|m| m - 50.0e-6 * speed(row.t_s));
        late.samples.push(&row);
    }
    whole
        .logged()
        .iter()
        .for_each(|column| late.samples.log(column.clone()));
    let answer = of(&late);
    let names: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["velocity_lag"], "{:?}", answer.verdict);
    assert!(
        answer.unexplained.follows.is_empty(),
        "{:?}",
        answer.unexplained
    );
}

/// A column that only rises is a clock, and lies over the time.
#[test]
fn a_column_that_only_rises_is_no_coordinate() {
    let mut rising = recording(4, |_, rh| 0.1e-6 * (rh - 40.0));
    let whole = std::mem::take(&mut rising.samples);
    (0..whole.len()).for_each(|i| rising.samples.push(&whole.row(i)));
    rising.samples.log(Logged {
        name: "aux_counter".into(),
        values: (0..COUNT).map(|k| k as f64).collect(),
    });
    let answer = of(&rising);
    let over = |s: &diagnosis::verdict::answer::Share| s.coordinate.contains("aux_");
    assert!(!answer.place.iter().any(over), "{:?}", answer.place);
    assert!(answer.unexplained.follows.is_empty());
}
