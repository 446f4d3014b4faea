//! `adc_clipping` on the plant's side: which ends it cuts, and that the sensor's side means the same by a rail.

use effects::adc_clipping::sensor_side::{parts, phase_error};
use effects::entry;
use effects::motion::Pose;
use effects::plant::{Channels, Geometry, Instant, PlantEffect, SEGMENTS, Scene};
use effects::random::{ChaCha8Rng, SeedableRng};
use effects::sensor::Clip;
use std::f64::consts::TAU;

const SCENE: Scene = Scene {
    geometry: Geometry::PAPER,
    duration_s: 100.0,
    amplitude_counts: 20_000.0,
};
const STEPS: usize = 720;

fn phase(step: usize) -> f64 {
    TAU * step as f64 / STEPS as f64 - 0.5 * TAU
}

/// A turn of whole pairs after the effect: `[step][segment][sine, cosine]`, of the amplitude.
fn turn(effect: &mut dyn PlantEffect) -> Vec<[[f64; 2]; SEGMENTS]> {
    let motion = Pose::default();
    let at = Instant {
        time_s: 0.0,
        pose: motion,
        temperature_delta_k: 0.0,
        motion: &motion,
        geometry: &SCENE.geometry,
    };
    let amplitude_counts = SCENE.amplitude_counts;
    let steps = (0..STEPS).map(|step| {
        let (sine, cosine) = phase(step).sin_cos();
        let mut channels = Channels {
            quadrature: [[sine, cosine].map(|v| v * amplitude_counts); SEGMENTS],
            amplitude_counts,
            ..Channels::default()
        };
        effect.analog(&at, &mut channels);
        channels
            .quadrature
            .map(|pair| pair.map(|v| v / amplitude_counts))
    });
    steps.collect()
}

/// Where a segment's channels end below and above.
fn ends(turn: &[[[f64; 2]; SEGMENTS]], segment: usize) -> [[f64; 2]; 2] {
    [0, 1].map(|channel| {
        let values = || turn.iter().map(|pairs| pairs[segment][channel]);
        [values().fold(0.0, f64::min), values().fold(0.0, f64::max)]
    })
}

/// True if some channel falls short of its whole wave at its steepest bend, and is flat nowhere.
fn is_soft(turn: &[[[f64; 2]; SEGMENTS]], segment: usize) -> bool {
    let rails = ends(turn, segment);
    (0..2).any(|channel| {
        let at = |value: f64| turn.iter().filter(|t| t[segment][channel] == value).count();
        rails[channel]
            .iter()
            .any(|rail| rail.abs() < 1.0 - 1e-6 && at(*rail) < 5)
    })
}

/// Rms over the phase of the phase error of a segment, and of what the sensor's side leaves of it with the best of many knees.
fn errors(turn: &[[[f64; 2]; SEGMENTS]], segment: usize) -> (f64, f64) {
    let wrapped = |off: f64| off - TAU * (off / TAU).round();
    let error = |step: usize| {
        let [sine, cosine] = turn[step][segment];
        wrapped(sine.atan2(cosine) - phase(step))
    };
    let rms = |of: &dyn Fn(usize) -> f64| {
        ((0..STEPS).map(|step| of(step).powi(2)).sum::<f64>() / STEPS as f64).sqrt()
    };
    let left = |rail: f64, knee: f64| {
        let clip = Clip {
            rails: [[-rail, rail]; 2],
            knee,
            ..Clip::default()
        };
        rms(&|step| wrapped(error(step) - phase_error(phase(step), &parts(&clip))))
    };
    let knees = (2..60).map(|k| 0.01 * f64::from(k));
    let tried = knees.flat_map(|knee| (40..180).map(move |rail| (0.01 * f64::from(rail), knee)));
    (
        rms(&error),
        tried
            .map(|(rail, knee)| left(rail, knee))
            .fold(f64::INFINITY, f64::min),
    )
}

/// Diodes and an amplifier do not saturate alike: the sensor's form comes near to the plant's, and is not it.
#[test]
fn a_knee_is_nearly_that_of_the_sensors_side() {
    let draw = entry("adc_clipping").unwrap().draw;
    let mut seen = 0;
    for seed in 0..200 {
        let mut effect = draw(&SCENE, &mut ChaCha8Rng::seed_from_u64(seed), 3.0e-6);
        let turn = turn(&mut *effect);
        let alike = |s: &usize| {
            let [[a, b], [c, d]] = ends(&turn, *s);
            is_soft(&turn, *s) && [b, d, -c].iter().all(|end| (end + a).abs() < 1e-9)
        };
        let Some(segment) = (0..SEGMENTS).find(alike) else {
            continue;
        };
        seen += 1;
        let (whole, left) = errors(&turn, segment);
        assert!(left < 0.1 * whole && left > 1e-5, "{left} of {whole}");
        if seen == 5 {
            return;
        }
    }
    panic!("{seen} draws with a knee");
}

#[test]
fn ends_are_cut_alike_or_not_and_both_sides_mean_the_same_by_a_rail() {
    let draw = entry("adc_clipping").unwrap().draw;
    let (mut alike, mut apart, mut one_end, mut soft) = (0, 0, 0, 0);
    for seed in 0..80 {
        let mut effect = draw(&SCENE, &mut ChaCha8Rng::seed_from_u64(seed), 2.0e-6);
        let turn = turn(&mut *effect);
        for segment in 0..SEGMENTS {
            let rails = ends(&turn, segment);
            if is_soft(&turn, segment) {
                soft += 1;
                continue;
            }
            for [low, high] in rails.into_iter().filter(|r| *r != [-1.0, 1.0]) {
                let both = low > -1.0 && high < 1.0;
                alike += usize::from(low == -high);
                apart += usize::from(both && low != -high);
                one_end += usize::from(!both);
            }
            let clip = Clip {
                rails,
                ..Clip::default()
            };
            for (step, pairs) in turn.iter().enumerate() {
                let [sine, cosine] = pairs[segment];
                let off = sine.atan2(cosine) - phase(step);
                let off = off - TAU * (off / TAU).round();
                assert!((off - phase_error(phase(step), &parts(&clip))).abs() < 1e-9);
            }
        }
    }
    let least = [alike, apart, one_end, soft].into_iter().min().unwrap();
    assert!(least >= 10, "{alike} {apart} {one_end} {soft}");
}
