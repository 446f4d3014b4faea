//! The simulator's own scatter: the recorded motion again, with the calibrated baseline and the stated noise.

use crate::data::observations::{Observations, ROUNDING};
use crate::linearization::recording::{LinearizedRecording, ROWS};
use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};
use effects::sensor::{CHANNELS, READINGS};
use std::f64::consts::TAU;

/// Scatter of a simulation without any effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floor {
    /// Rms of each channel, m.
    pub channel_rms_m: [f64; CHANNELS],
    /// Mean square of the whitened residuals: 1 but for rounding and curvature.
    pub white_square: f64,
}

/// Times that the motion is repeated. Derived from the scatter of a mean square, `√(2/n)` of so many samples: of 5,000 samples and as many
/// rows four repeats tell it to a hundredth.
const REPEATS: u64 = 4;

/// Repeats the motion some times and pools them. Every kept sample is simulated in each.
pub fn floor(linearized: &LinearizedRecording) -> Floor {
    let mut sums = [(0.0, 0usize); CHANNELS];
    let mut white = (0.0, 0usize);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let step = (linearized.len() / 20_000).max(1);
    for _ in 0..REPEATS {
        for i in (0..linearized.len())
            .step_by(step)
            .filter(|&i| linearized.mask[i])
        {
            let rows = linearized.rows(i);
            if rows.count == 0 {
                continue;
            }
            let error = reading_errors(linearized, i, &mut rng);
            let mut value = [0.0; ROWS];
            for row in 0..rows.count {
                value[row] = rows.by_reading[row]
                    .iter()
                    .zip(&error)
                    .map(|(j, e)| j * e)
                    .sum();
                sums[rows.channel[row]].0 += value[row] * value[row];
                sums[rows.channel[row]].1 += 1;
            }
            let w = rows.whitened(&value);
            white.0 += w[..rows.count].iter().map(|v| v * v).sum::<f64>();
            white.1 += rows.count;
        }
    }
    Floor {
        channel_rms_m: sums.map(|(s, n)| if n > 0 { (s / n as f64).sqrt() } else { 0.0 }),
        white_square: if white.1 > 0 {
            white.0 / white.1 as f64
        } else {
            1.0
        },
    }
}

/// Errors of the calibrated readings that the stated noise and the converter's rounding give.
fn reading_errors(
    linearized: &LinearizedRecording,
    i: usize,
    rng: &mut ChaCha8Rng,
) -> [f64; READINGS] {
    let o = linearized.observations;
    let mut out = [0.0; READINGS];
    for segment in (0..4).filter(|s| linearized.scope.segments[*s]) {
        let [there, read] = read_again(o, segment, i, rng);
        let (before, _) = linearized.baseline.calibrated(segment, there, o.pitch_m);
        let (after, _) = linearized.baseline.calibrated(segment, read, o.pitch_m);
        out[segment] = after - before;
    }
    for axis in 0..2 {
        let noise = o.tan_psi_noise[axis].get(i).copied().unwrap_or(0.0);
        out[4 + axis] = if noise.is_finite() {
            noise * normal(rng)
        } else {
            0.0
        };
    }
    out
}

/// An output that the converter may have rounded to what was recorded, and what it would read there the next time, m.
fn read_again(o: &Observations, segment: usize, i: usize, rng: &mut ChaCha8Rng) -> [f64; 2] {
    let recorded = o.position_m[segment][i];
    let Some(&amplitude) = o.amplitude_counts[segment].get(i) else {
        return [
            recorded,
            recorded + o.position_noise_m[segment][i] * normal(rng),
        ];
    };
    let phase = TAU * recorded / o.pitch_m;
    let noise = (o.pair_noise_counts.powi(2) - ROUNDING).max(0.0).sqrt();
    let at = |turn: f64| {
        let turn = turn - phase;
        recorded + (turn - (turn / TAU).round() * TAU) / TAU * o.pitch_m
    };
    let pair = [phase.sin(), phase.cos()].map(|v| amplitude * v + uniform(rng, -0.5, 0.5));
    let read = pair.map(|v| (v + noise * normal(rng)).round());
    [pair, read].map(|[sine, cosine]| at(sine.atan2(cosine)))
}
