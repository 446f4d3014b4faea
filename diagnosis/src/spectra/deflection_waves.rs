//! Waves over the deflection of the coordination sensor in any direction, shorter than those that are always tried: fringes of a
//! window, or the grain of a detector. Least squares at each wave vector (Lomb 1976, in two dimensions).

use crate::algebra::fourier::Orders;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LinearizedRecording;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Most waves that are looked for. A bound on the work: further ones are left to the other shapes over the deflection.
const WAVES: usize = 2;
/// Most turns over a full scale. A bound on the work: finer fringes are left to the noise.
const TURNS: f64 = 20.0;
/// Turns over the range of the deflection from one trial to the next: a wave between two trials keeps nine tenths of its power.
/// Derived from sinc² of half a step, 0.18 turns, which is 0.90.
const WAVE_STEP_TURNS: f64 = 0.35;
/// A wave is told if it takes this share of the squares: what it takes by chance of some thousand samples, the best of all
/// trials, is a tenth of that. Derived from that chance: the best of 60 trials takes 2 ln(60) / 1000, under a hundredth.
const LEAST_WAVE_SHARE: f64 = 0.1;
/// Fewer residuals tell no wave. Derived from `LEAST_WAVE_SHARE`, which is ten times chance from here on.
const FEWEST_WAVE_SAMPLES: usize = 1000;
/// Halvings of the step about the best trial. Derived from `WAVE_STEP_TURNS`: a hundredth of a turn, at which a wave keeps 0.9999
/// of its power.
const WAVE_HALVINGS: usize = 5;

/// Residuals of one channel over the deflection.
struct Series {
    at: Vec<[f64; 2]>,
    value: Vec<f64>,
}

/// Wave vectors, turns over a full scale, that stand out of the residuals of g_x and g_y, strongest first; each is taken out
/// before the next is looked for. Cost: a transform of the trials for each of some hundred wave numbers across.
pub fn waves(linearized: &LinearizedRecording, residuals: &Residuals) -> Vec<[f64; 2]> {
    let mut series = [1, 2].map(|channel| Series::of(linearized, residuals, channel));
    let mut found = Vec::new();
    if series.iter().any(|s| s.value.len() < FEWEST_WAVE_SAMPLES) {
        return found;
    }
    for _ in 0..WAVES {
        let Some(wave) = strongest(&series) else {
            break;
        };
        found.push(wave);
        series.iter_mut().for_each(|s| s.take_out(wave));
    }
    found
}

/// The wave that takes most, if that is enough.
fn strongest(series: &[Series; 2]) -> Option<[f64; 2]> {
    let step =
        [0, 1].map(|axis| WAVE_STEP_TURNS / range(series, axis).max(WAVE_STEP_TURNS / TURNS));
    let highest = step.map(|s| (TURNS / s).ceil() as usize);
    let orders = Orders::new(highest[0]);
    let best_of = |across: usize| {
        let powers = series.iter().map(|s| s.powers(&orders, step, across));
        let sum = powers.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect());
        let along = sum.unwrap_or_default().into_iter().enumerate();
        let best = along.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((best.1, [best.0 as f64 * step[0], across as f64 * step[1]]))
    };
    let rows: Vec<_> = (0..=highest[1]).into_par_iter().map(best_of).collect();
    let (_, trial) = rows
        .into_iter()
        .flatten()
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let taken = |wave: [f64; 2]| -> f64 { series.iter().map(|s| s.taken(wave)).sum() };
    // The transform does not tell a wave from its mirror image.
    let mirrored = [-trial[0], trial[1]];
    let mut best = if taken(trial) > taken(mirrored) {
        trial
    } else {
        mirrored
    };
    for halving in 1..=WAVE_HALVINGS {
        let by = step.map(|s| s * 0.5_f64.powi(halving as i32));
        let near = (-1..=1).flat_map(|a| (-1..=1).map(move |b| [f64::from(a), f64::from(b)]));
        best = near
            .map(|n| [best[0] + n[0] * by[0], best[1] + n[1] * by[1]])
            .max_by(|a, b| taken(*a).total_cmp(&taken(*b)))?;
    }
    let whole: f64 = series.iter().flat_map(|s| &s.value).map(|v| v * v).sum();
    (taken(best) > LEAST_WAVE_SHARE * whole).then_some(best)
}

fn range(series: &[Series; 2], axis: usize) -> f64 {
    let all = series.iter().flat_map(|s| &s.at).map(|at| at[axis]);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    high - low
}

impl Series {
    fn of(linearized: &LinearizedRecording, residuals: &Residuals, channel: usize) -> Self {
        let of_it = |k: &usize| residuals.channel[*k] == channel;
        let list: Vec<usize> = (0..residuals.sample.len()).filter(of_it).collect();
        let deflection = |k: &usize| linearized.covariates(residuals.sample[*k]).deflection;
        Self {
            at: list.iter().map(deflection).collect(),
            value: list.iter().map(|k| residuals.white[*k]).collect(),
        }
    }

    /// Power at each wave number along the first axis, with one across, and that of its mirror image.
    fn powers(&self, orders: &Orders, step: [f64; 2], across: usize) -> Vec<f64> {
        let points = self.at.iter().zip(&self.value).map(|(at, value)| {
            let turns = across as f64 * step[1] * at[1];
            (at[0] * step[0], Complex::from_polar(*value, TAU * turns))
        });
        orders.powers(points)
    }

    /// Sine and cosine of a wave at each residual, and what they are of it by least squares.
    fn fitted(&self, wave: [f64; 2]) -> (f64, f64) {
        let (mut ss, mut sc, mut cc, mut sv, mut cv) = (1e-9, 0.0, 1e-9, 0.0, 0.0);
        for (at, value) in self.at.iter().zip(&self.value) {
            let (s, c) = phase(wave, at).sin_cos();
            (ss, sc, cc) = (ss + s * s, sc + s * c, cc + c * c);
            (sv, cv) = (sv + s * value, cv + c * value);
        }
        let determinant = (ss * cc - sc * sc).max(1e-9);
        (
            (cc * sv - sc * cv) / determinant,
            (ss * cv - sc * sv) / determinant,
        )
    }

    /// Squares that a wave takes, to within what its sine and cosine share.
    fn taken(&self, wave: [f64; 2]) -> f64 {
        let (sine, cosine) = self.fitted(wave);
        let of = |at: &[f64; 2]| {
            let (s, c) = phase(wave, at).sin_cos();
            sine * s + cosine * c
        };
        let rows = self.at.iter().zip(&self.value);
        rows.map(|(at, value)| value * value - (value - of(at)).powi(2))
            .sum()
    }

    fn take_out(&mut self, wave: [f64; 2]) {
        let (sine, cosine) = self.fitted(wave);
        for (at, value) in self.at.iter().zip(&mut self.value) {
            let (s, c) = phase(wave, at).sin_cos();
            *value -= sine * s + cosine * c;
        }
    }
}

fn phase(wave: [f64; 2], at: &[f64; 2]) -> f64 {
    TAU * (wave[0] * at[0] + wave[1] * at[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};

    fn series(wave: Option<[f64; 2]>) -> [Series; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        [0.4, 1.9].map(|shift| {
            let mut at = || [uniform(&mut rng, -0.8, 0.8), uniform(&mut rng, -0.5, 0.7)];
            let at: Vec<[f64; 2]> = (0..1500).map(|_| at()).collect();
            let size = if wave.is_some() { 1.0 } else { 0.0 };
            let value = at
                .iter()
                .map(|p| {
                    size * (phase(wave.unwrap_or_default(), p) + shift).sin() + normal(&mut rng)
                })
                .collect();
            Series { at, value }
        })
    }

    /// In any direction, and with either sign; noise alone has none.
    #[test]
    fn a_wave_is_found_where_it_is() {
        for wave in [[6.3, 2.1], [-5.2, 9.4], [0.1, 13.7]] {
            let found = strongest(&series(Some(wave))).unwrap();
            let sign = if found[0] * wave[0] + found[1] * wave[1] < 0.0 {
                -1.0
            } else {
                1.0
            };
            for (found, wave) in found.iter().zip(wave) {
                assert!((sign * found - wave).abs() < 0.05, "{found} for {wave}");
            }
        }
        assert!(strongest(&series(None)).is_none());
    }
}
