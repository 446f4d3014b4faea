//! A field of displaced teeth under one segment beside a reference, over a few teeth: where they lie is not known, and another
//! effect may be beside it.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use effects::random::{ChaCha8Rng, SeedableRng, normal};
use recording::{Electronics, Geometry, Meta, Recording, Row, Samples};
use std::f64::consts::TAU;

const PITCH_M: f64 = 1.016e-3;
const NOISE_M: f64 = 0.15e-6;
const TEETH: usize = 24;

/// Posts under a rectangle with sharp edges, `width` teeth either way, the first of them `first` pitches from the marks.
struct Teeth {
    posts_m: Vec<f64>,
    width: f64,
    first: f64,
}

impl Teeth {
    fn draw(seed: u64, width: f64, first: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Self {
            posts_m: (0..TEETH * TEETH)
                .map(|_| 8.0e-6 * normal(&mut rng))
                .collect(),
            width,
            first,
        }
    }

    fn at_m(&self, place_m: [f64; 2]) -> f64 {
        let cover = |place_m: f64, tooth: usize| {
            let away = tooth as f64 - 0.5 * TEETH as f64 + self.first - place_m / PITCH_M;
            (0.5 * self.width + 0.5 - away.abs()).clamp(0.0, 1.0)
        };
        let (mut sum, mut whole) = (0.0, 0.0);
        for (k, post_m) in self.posts_m.iter().enumerate() {
            let weight = cover(place_m[0], k % TEETH) * cover(place_m[1], k / TEETH);
            sum += weight * post_m;
            whole += weight;
        }
        sum / whole
    }
}

/// To and fro within a few teeth along and across; `besides` is what else is wrong, of place and speed.
fn told(teeth: Option<&Teeth>, besides: impl Fn([f64; 2], f64) -> f64) -> Diagnosis {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let mut samples = Samples::default();
    for run in 0..4 {
        let rate = |k: f64| TAU * (1.0 + 0.3 * k + 0.17 * f64::from(run));
        let (along, across) = (rate(3.0), rate(0.0));
        for k in 0..2500 {
            let t_s = f64::from(k) * 2.0e-3;
            let size_m = 1.5e-3;
            let place_m = [size_m * (along * t_s).sin(), size_m * (across * t_s).cos()];
            let speed_m_s = size_m * along * (along * t_s).cos();
            let phase = TAU * place_m[0] / PITCH_M;
            let error_m = 3.0e-6 * phase.sin() + 1.0e-6 * (2.0 * phase).cos();
            let field_m = teeth.map_or(0.0, |teeth| teeth.at_m(place_m));
            let off_m =
                error_m + field_m + besides(place_m, speed_m_s) + NOISE_M * normal(&mut rng);
            samples.push(&Row {
                t_s: t_s + 10.0 * f64::from(run),
                run: ["a", "b", "c", "d"][run as usize],
                position_m: [Some(place_m[0] + off_m), None, None, None],
                reference: [Some(place_m[0]), Some(place_m[1]), Some(0.0)],
                ..Row::default()
            });
        }
    }
    let recording = Recording {
        meta: Meta {
            geometry: Geometry {
                pitch_m: PITCH_M,
                span_m: Some(9.7e-3),
                lateral_m: Some(3.0e-3),
            },
            electronics: Electronics {
                position_noise_m: Some(NOISE_M),
                ..Electronics::default()
            },
            ..Meta::default()
        },
        samples,
        warnings: Vec::new(),
    };
    diagnose(&recording, "field", &Options::default())
}

fn assert_named(d: &Diagnosis, wanted: &[&str]) {
    let mut names: Vec<&str> = d.effects.iter().map(|e| e.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, wanted, "{:?} {:?}", d.verdict, d.held_out);
}

fn nothing(_: [f64; 2], _: f64) -> f64 {
    0.0
}

/// The field bends where a tooth comes in, which may be anywhere beside the marks and in either phase of the two edges.
#[test]
fn a_field_is_named_wherever_its_teeth_lie() {
    for (width, first) in [(4.0, 0.3), (5.0, 0.0), (5.0, 0.75)] {
        let d = told(Some(&Teeth::draw(5, width, first)), nothing);
        assert_named(&d, &["tooth_variation"]);
        // Three standard deviations of the rms of as many deviates as there are samples.
        let chance = 3.0 / (2.0 * d.gap[0].samples as f64).sqrt();
        let after = d.held_out.whitened_after;
        assert!(after < 1.0 + chance, "{width} {first}: {after} is left");
    }
}

/// Beside another cause a few waves over the platen describe a part of the field, with whatever describes the rest.
#[test]
fn a_field_beside_another_cause_is_named() {
    let teeth = Teeth::draw(6, 5.0, 0.2);
    let lateral = |place_m: [f64; 2], _: f64| 2.0e-6 * (TAU * place_m[1] / PITCH_M + 0.4).sin();
    let d = told(Some(&teeth), lateral);
    assert_named(&d, &["lateral_dependence", "tooth_variation"]);
    let late = |_: [f64; 2], speed_m_s: f64| -150.0e-6 * speed_m_s;
    assert_named(
        &told(Some(&teeth), late),
        &["tooth_variation", "velocity_lag"],
    );
}

/// What is no field is not taken for one, though few teeth were passed and the field is free there: neither a wave of half a
/// tooth's order nor one that follows both the place and the speed.
#[test]
fn another_shape_over_few_teeth_is_no_field() {
    let half = |place_m: [f64; 2], _: f64| 2.0e-6 * (1.5 * TAU * place_m[0] / PITCH_M).sin();
    no_field(&told(None, half));
    assert_eq!(told(None, nothing).verdict, Verdict::NoGap);
}

#[test]
#[ignore = "nightly: a quarter of a minute"]
fn what_follows_place_and_speed_over_few_teeth_is_no_field() {
    let mixed = |place_m: [f64; 2], speed_m_s: f64| {
        60.0e-6 * speed_m_s * (TAU * place_m[0] / PITCH_M).cos()
    };
    no_field(&told(None, mixed));
}

fn no_field(d: &Diagnosis) {
    let field = |e: &diagnosis::verdict::answer::Named| e.name == "tooth_variation";
    assert!(!d.effects.iter().any(field), "{:?}", d.effects);
    assert_eq!(d.verdict, Verdict::Unknown, "{:?}", d.effects);
}
