//! The clip of a pair by the shape of its error against a reference, where no counts were logged: rails that lie alike and are hard.
//! A knee is not looked for: tried on `ess-rotary-normal`, one took what is not its own, and with clips withheld the orders 4, 8, 12
//! and 16 that tell of one were told no more.

use super::rails::{WHOLE, cutting};
use crate::linearization::recording::LinearizedRecording;
use effects::rails::phase_error;
use effects::sensor::Clip;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::TAU;

/// Levels, offsets, gain, angle, shift, delay and electrical zero. A definition: two, two and one each.
const FIGURE_PARAMETERS: usize = 9;
type Parameters = SVector<f64, FIGURE_PARAMETERS>;

/// Levels, offsets, gain and angle of the pair, with a shift and a delay beside them. The ends of a channel are taken to be cut alike:
/// with equation (3) free beside them, positions alone do not tell an offset from a rail.
pub(super) fn find(linearized: &LinearizedRecording, segment: usize) -> Option<Clip> {
    let o = linearized.observations;
    let metres = o.pitch_m / TAU;
    let usable: Vec<usize> = (0..o.len())
        .filter(|&i| {
            linearized.motion.direction[segment][i] != 0.0 && o.reference_m(segment, i).is_finite()
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
                linearized.motion.speed_m_s[segment][i] / metres,
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
    if !found {
        return None;
    }
    let pair = [p[2], p[3], p[4], p[5]];
    Some(Clip {
        rails: cutting([0, 1].map(|c| [-p[c], p[c]].map(Some)), &pair, 0.0)?,
        pair,
        knee: 0.0,
        zero_and_delay: Some([p[8], p[7] / top_speed]),
    })
}

fn error(p: &Parameters, phase: f64, speed: f64, top_speed: f64) -> f64 {
    let late = p[7] * speed / top_speed;
    let parts = [-p[0], p[0], -p[1], p[1], p[2], p[3], p[4], p[5], 0.0];
    phase_error(phase + p[8] - late, &parts) + p[6] - late
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
        let mut normal = SMatrix::<f64, FIGURE_PARAMETERS, FIGURE_PARAMETERS>::zeros();
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
        for j in 0..FIGURE_PARAMETERS {
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
