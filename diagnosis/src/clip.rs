//! Flat tops: in the counts where there are any, else in the shape of the error against a reference.

use crate::observe::Observations;
use crate::scene::Scene;
use crate::statistics::median;
use effects::adc_clipping::sensor_side::phase_error;
use effects::sensor::Clip;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::TAU;

/// Level from which on a channel counts as whole.
const WHOLE: f64 = 0.99;

/// The clip of a segment, if it has one.
pub fn find(scene: &Scene, segment: usize) -> Option<Clip> {
    let o = scene.observations;
    if !o.pair_counts[segment].is_empty() {
        return in_counts(o, segment);
    }
    if scene.scope.reference && scene.scope.segments[segment] {
        against_reference(scene, segment)
    } else {
        None
    }
}

/// The counts pile up at a level that the amplitude exceeds.
fn in_counts(o: &Observations, segment: usize) -> Option<Clip> {
    let pairs: Vec<[f64; 2]> = o.pair_counts[segment]
        .iter()
        .copied()
        .filter(|p| p[0].is_finite())
        .collect();
    // At 45 degrees neither channel is near its top, unless they are cut below 0.71 of the amplitude.
    let mut radii: Vec<f64> = pairs
        .iter()
        .filter(|p| p[0].abs() > 0.0 && (p[1].abs() / p[0].abs()).ln().abs() < 0.15)
        .map(|p| p[0].hypot(p[1]))
        .collect();
    if radii.len() < 30 {
        return None;
    }
    let diagonal = median(&mut radii)?;
    let tops = [0, 1].map(|channel| top(&pairs, channel));
    let deep = diagonal > DIAGONAL * tops[0].hypot(tops[1]);
    let amplitude = if deep {
        whole_amplitude(o, segment).unwrap_or(diagonal)
    } else {
        diagonal
    };
    let level = [0, 1].map(|channel| flat_top(&pairs, channel, amplitude, o.pair_noise_counts));
    level.iter().any(|l| *l < WHOLE).then_some(Clip {
        level: level.map(|l| if l < WHOLE { l } else { 1.5 }),
        pair: None,
        zero_and_delay: [0.0; 2],
    })
}

/// At 45 degrees this near to both tops, both channels are cut.
const DIAGONAL: f64 = 0.98;

/// Amplitude of a pair that is cut even at 45 degrees: what is stated, else what the whole pairs have.
fn whole_amplitude(o: &Observations, segment: usize) -> Option<f64> {
    let stated = o.stated_amplitude_counts;
    let others = (0..4).filter(|s| *s != segment).filter_map(|s| {
        let mut list = o.amplitude_counts[s].clone();
        list.retain(|a| a.is_finite());
        median(&mut list)
    });
    if stated.is_finite() {
        Some(stated)
    } else {
        others.max_by(f64::total_cmp)
    }
}

/// A channel's top, counts: what one sample in 200 exceeds.
fn top(pairs: &[[f64; 2]], channel: usize) -> f64 {
    let mut magnitude: Vec<f64> = pairs.iter().map(|p| p[channel].abs()).collect();
    let at = magnitude.len() - 1 - magnitude.len() / 200;
    *magnitude.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Level of a flat top relative to the amplitude; 1.5 if there is none.
fn flat_top(pairs: &[[f64; 2]], channel: usize, amplitude: f64, noise: f64) -> f64 {
    let magnitude: Vec<f64> = pairs.iter().map(|p| p[channel].abs()).collect();
    let top = top(pairs, channel);
    let level = top / amplitude;
    if level >= WHOLE {
        return 1.5;
    }
    let width = (4.0 * noise).max(0.002 * amplitude);
    let held =
        magnitude.iter().filter(|m| **m > top - width).count() as f64 / magnitude.len() as f64;
    // A sine's own share of time within `width` below that level.
    let own = ((top / amplitude).asin() - ((top - width) / amplitude).asin()) * 2.0
        / std::f64::consts::PI;
    if held > 3.0 * own.max(0.005) {
        level
    } else {
        1.5
    }
}

/// Levels, offsets, gain, angle, shift, delay and electrical zero.
const UNKNOWN: usize = 9;
type Parameters = SVector<f64, UNKNOWN>;

/// Levels, offsets, gain and angle of the pair, with a shift and a delay beside them, against a reference.
fn against_reference(scene: &Scene, segment: usize) -> Option<Clip> {
    let o = scene.observations;
    let metres = o.pitch_m / TAU;
    let usable: Vec<usize> = (0..o.len())
        .filter(|&i| {
            scene.motion.direction[segment][i] != 0.0 && o.reference_m(segment, i).is_finite()
        })
        .collect();
    if usable.len() < 200 {
        return None;
    }
    let step = (usable.len() / 2500).max(1);
    let points: Vec<(f64, f64, f64)> = usable
        .iter()
        .step_by(step)
        .map(|&i| {
            let reference = o.reference_m(segment, i);
            (
                (o.position_m[segment][i] - reference) / metres,
                reference / metres,
                scene.motion.speed_m_s[segment][i] / metres,
            )
        })
        .collect();
    let top_speed = points.iter().map(|p| p.2.abs()).fold(1e-12, f64::max);
    let quarter = std::f64::consts::FRAC_PI_2;
    let best = [
        (0.66, 0.0),
        (0.66, 0.25),
        (0.66, 0.5),
        (0.66, 0.75),
        (0.85, 0.0),
        (0.85, 0.33),
        (0.85, 0.67),
    ]
    .into_iter()
    .filter_map(|(level, part)| {
        let mut start = Parameters::zeros();
        start[0] = level;
        start[1] = level;
        start[8] = part * quarter;
        refine(&points, start, top_speed)
    })
    .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let open = refine(
        &points,
        {
            let mut p = Parameters::zeros();
            p[0] = 3.0;
            p[1] = 3.0;
            p
        },
        top_speed,
    )?;
    let p = best.0;
    let found = p[0].min(p[1]) < WHOLE && best.1 < 0.8 * open.1;
    found.then(|| Clip {
        level: [p[0], p[1]],
        pair: Some([p[2], p[3], p[4], p[5]]),
        zero_and_delay: [p[8], p[7] / top_speed],
    })
}

fn error(p: &Parameters, phase: f64, speed: f64, top_speed: f64) -> f64 {
    let late = p[7] * speed / top_speed;
    phase_error(phase + p[8] - late, &[p[0], p[1], p[2], p[3], p[4], p[5]]) + p[6] - late
}

/// Damped Gauss-Newton with differenced derivatives; the parameters and the sum of squares.
fn refine(
    points: &[(f64, f64, f64)],
    start: Parameters,
    top_speed: f64,
) -> Option<(Parameters, f64)> {
    let wrapped = |e: f64| e - TAU * (e / TAU).round();
    let cost = |p: &Parameters| {
        points
            .iter()
            .map(|(e, phase, v)| wrapped(e - error(p, *phase, *v, top_speed)).powi(2))
            .sum::<f64>()
    };
    let mut p = start;
    let mut now = cost(&p);
    let mut damping = 1e-3;
    for _ in 0..25 {
        let mut normal = SMatrix::<f64, UNKNOWN, UNKNOWN>::zeros();
        let mut right = Parameters::zeros();
        for (e, phase, v) in points {
            let here = error(&p, *phase, *v, top_speed);
            let slope = Parameters::from_fn(|j, _| {
                let mut more = p;
                more[j] += 1e-4;
                (error(&more, *phase, *v, top_speed) - here) / 1e-4
            });
            normal += slope * slope.transpose();
            right += slope * wrapped(e - here);
        }
        for j in 0..UNKNOWN {
            normal[(j, j)] += damping * normal[(j, j)] + 1e-6 * points.len() as f64;
        }
        let step = normal.cholesky()?.solve(&right);
        let mut next = p + step;
        next[0] = next[0].clamp(0.3, 3.0);
        next[1] = next[1].clamp(0.3, 3.0);
        let value = cost(&next);
        if value < now {
            let small = now - value < 1e-7 * now;
            (p, now, damping) = (next, value, damping * 0.3);
            if small {
                break;
            }
        } else {
            damping *= 8.0;
        }
    }
    Some((p, now))
}
