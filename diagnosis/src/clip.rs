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
    let known = |p: &&[f64; 2]| p[0].is_finite() && p[1].is_finite();
    let pairs: Vec<[f64; 2]> = o.pair_counts[segment]
        .iter()
        .filter(known)
        .copied()
        .collect();
    // Over separate poses neighbours show no noise: what is stated is tried before what they show.
    let noises = [o.pair_noise_counts, shown_noise(&o.pair_counts[segment])];
    let top = |channel| noises.iter().find_map(|n| flat_top(&pairs, channel, *n));
    let tops = [0, 1].map(top);
    let amplitude = match tops {
        [None, None] => return None,
        // Where one channel is cut, the other is whole at the first's zeros.
        [Some(_), None] => at_zeros_of(&pairs, 0)?,
        [None, Some(_)] => at_zeros_of(&pairs, 1)?,
        [Some(sine), Some(cosine)] => amplitude_of_both(o, segment, &pairs, sine.hypot(cosine))?,
    };
    let level = tops.map(|top| top.map(|top| top / amplitude).filter(|l| *l < WHOLE));
    level.iter().any(Option::is_some).then_some(Clip {
        level: level.map(|l| l.unwrap_or(1.5)),
        pair: None,
        zero_and_delay: [0.0; 2],
    })
}

/// At 45 degrees this near to both tops, both channels are cut there.
const DIAGONAL: f64 = 0.98;
/// Fewer samples at a phase tell no amplitude.
const LEAST: usize = 30;

/// Amplitude of a pair with both channels cut: at 45 degrees neither is near its top, unless they are cut below 0.71 of it.
fn amplitude_of_both(
    o: &Observations,
    segment: usize,
    pairs: &[[f64; 2]],
    corner: f64,
) -> Option<f64> {
    let mut radii: Vec<f64> = pairs
        .iter()
        .filter(|p| p[0].abs() > 0.0 && (p[1].abs() / p[0].abs()).ln().abs() < 0.15)
        .map(|p| p[0].hypot(p[1]))
        .collect();
    if radii.len() < LEAST {
        return None;
    }
    let diagonal = median(&mut radii)?;
    if diagonal > DIAGONAL * corner {
        return whole_amplitude(o, segment).or(Some(diagonal));
    }
    Some(diagonal)
}

/// Amplitude of the other channel, where one is about zero.
fn at_zeros_of(pairs: &[[f64; 2]], channel: usize) -> Option<f64> {
    let near = 0.1 * top(pairs, channel);
    let mut other: Vec<f64> = pairs
        .iter()
        .filter(|p| p[channel].abs() < near)
        .map(|p| p[1 - channel].abs())
        .collect();
    if other.len() < LEAST {
        None
    } else {
        median(&mut other)
    }
}

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
    let at = magnitude.len().saturating_sub(1 + magnitude.len() / 200);
    *magnitude.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Noise of a channel, counts, as the bends of the amplitude between neighbours show it.
fn shown_noise(pairs: &[[f64; 2]]) -> f64 {
    let radius: Vec<f64> = pairs.iter().map(|p| p[0].hypot(p[1])).collect();
    let mut bends: Vec<f64> = radius
        .windows(3)
        .map(|r| (r[0] - 2.0 * r[1] + r[2]) / 6f64.sqrt())
        .filter(|b| b.is_finite())
        .collect();
    crate::statistics::median_and_deviation(&mut bends).map_or(0.0, |b| b.1)
}

/// A channel is cut if it stays at its top this much longer than a sine does, and longer by this share of the time.
const LONGER: f64 = 1.8;
/// See [`LONGER`].
const SHARE: f64 = 0.03;

/// Counts that a channel's flat tops stand at, if it has any.
fn flat_top(pairs: &[[f64; 2]], channel: usize, noise: f64) -> Option<f64> {
    if pairs.len() < LEAST {
        return None;
    }
    let top = top(pairs, channel);
    let width = (4.0 * noise).max(0.002 * top).min(WIDEST * top);
    let mut held: Vec<f64> = pairs
        .iter()
        .map(|p| p[channel].abs())
        .filter(|m| *m > top - width)
        .collect();
    let share = held.len() as f64 / pairs.len() as f64;
    // A sine's own share of time within `width` below its top.
    let own = (1.0 - width / top).acos() * 2.0 / std::f64::consts::PI;
    if share > LONGER * own && share > own + SHARE {
        median(&mut held)
    } else {
        None
    }
}

/// Widest band below the top that is looked at, of the top.
const WIDEST: f64 = 0.06;

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
