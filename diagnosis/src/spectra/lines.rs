//! Lines in the spectrum of unevenly sampled residuals: least squares at each frequency (Lomb 1976, Scargle 1982).

use crate::algebra::fourier::Orders;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LinearizedRecording;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Most lines that are looked for. A bound on the work: weaker lines are left to what wanders and to the noise.
const LINES: usize = 3;
/// Frequencies that are tried at most. A bound on the work: in pieces of over 3,600 samples they lie further apart than a third
/// of a turn, and a line between two of them may be missed.
const TRIALS: usize = 6_000;

/// Slower than one turn a piece is drift, not a line: the first trial, in steps of which the longest piece holds 0.3. By
/// definition the fourth, of 1.2 turns a piece.
const SLOWEST: usize = 4;

/// One residual series: times (s), values over their noise.
pub struct Series<'a> {
    /// Times, s, increasing.
    pub t_s: &'a [f64],
    /// Values in standard deviations.
    pub value: Vec<f64>,
    /// Stretch of each sample.
    pub stretch: &'a [usize],
}

/// Frequencies whose power summed over the series stands out beyond chance among all that were tried, strongest first.
/// `refine` subtracts each found line before the next is looked for. Cost: a transform of the trials for each two pieces, side by side.
pub fn lines_hz(series: &mut [Series]) -> Vec<f64> {
    let mut found = Vec::new();
    for _ in 0..LINES {
        let Some(hz) = strongest(series) else { break };
        found.push(hz);
        for one in series.iter_mut() {
            subtract(one, hz);
        }
    }
    found
}

/// An unbroken piece of a series.
#[derive(Clone, Copy, Debug)]
struct Piece {
    series: usize,
    start: usize,
    end: usize,
    interval_s: f64,
    length_s: f64,
}

/// Pieces of all series, by increasing interval.
fn pieces(series: &[Series]) -> Vec<Piece> {
    let mut list = Vec::new();
    for (number, one) in series.iter().enumerate() {
        let mut start = 0;
        for i in 1..=one.t_s.len() {
            if i == one.t_s.len() || one.stretch[i] != one.stretch[start] {
                let length_s = one.t_s[i - 1] - one.t_s[start];
                if i - start > 20 {
                    list.push(Piece {
                        series: number,
                        start,
                        end: i,
                        interval_s: length_s / (i - 1 - start) as f64,
                        length_s,
                    });
                }
                start = i;
            }
        }
    }
    list.sort_by(|a, b| a.interval_s.total_cmp(&b.interval_s));
    list
}

/// Pieces of about the same sample rate together: each group has its own resolution and its own highest frequency.
fn groups(series: &[Series]) -> Vec<Vec<Piece>> {
    let mut list: Vec<Vec<Piece>> = Vec::new();
    for piece in pieces(series) {
        match list
            .last_mut()
            .filter(|g| piece.interval_s < 4.0 * g[0].interval_s)
        {
            Some(group) => group.push(piece),
            None => list.push(vec![piece]),
        }
    }
    list
}

/// Power at each multiple of a frequency up to the highest one, summed over pieces: each has its own phase.
fn powers(series: &[Series], group: &[Piece], step_hz: f64, highest: usize) -> Vec<f64> {
    let orders = Orders::new(highest);
    // Two pieces share a transform.
    let two = |pieces: &[Piece]| {
        let units = [Complex::new(1.0, 0.0), Complex::new(0.0, 1.0)];
        let points = pieces.iter().zip(units);
        orders.powers(points.flat_map(|(p, unit)| points_of(&series[p.series], *p, step_hz, unit)))
    };
    let each: Vec<Vec<f64>> = group.par_chunks(2).map(two).collect();
    (0..=highest)
        .map(|k| each.iter().map(|powers| powers[k]).sum())
        .collect()
}

/// A piece's samples as turns of a frequency and values, of which the squared sum is the power.
fn points_of<'a>(
    one: &'a Series,
    piece: Piece,
    hz: f64,
    unit: Complex<f64>,
) -> impl Iterator<Item = (f64, Complex<f64>)> + 'a {
    let weight = unit * (2.0 / (piece.end - piece.start) as f64).sqrt();
    (piece.start..piece.end).map(move |i| {
        let turns = hz * (one.t_s[i] - one.t_s[piece.start]);
        (turns, weight * one.value[i])
    })
}

/// Power with one phase over all samples at `count` frequencies, `step_hz` apart from `first_hz` on.
fn coherent(series: &[Series], first_hz: f64, step_hz: f64, count: usize) -> Vec<f64> {
    let orders = Orders::new(count.max(1) - 1);
    let of_one = |one: &Series| {
        let samples = one.t_s.iter().zip(&one.value);
        let points = samples.map(|(&t_s, &value)| {
            let back = Complex::from_polar(value, -TAU * first_hz * t_s);
            (step_hz * t_s, back)
        });
        let scale = 2.0 / one.t_s.len().max(1) as f64;
        orders
            .turned_back(points)
            .into_iter()
            .map(move |p| scale * p)
    };
    let mut sum = vec![0.0; count];
    for one in series {
        let powers = sum.iter_mut().zip(of_one(one));
        powers.for_each(|(sum, power)| *sum += power);
    }
    sum
}

fn strongest(series: &[Series]) -> Option<f64> {
    let groups = groups(series);
    let found = groups.iter().find_map(|group| peak(series, group))?;
    let (coarse, _, step) = found;
    // The whole recording resolves far finer than one piece.
    let whole = series
        .iter()
        .map(|s| s.t_s.last().unwrap_or(&0.0) - s.t_s.first().unwrap_or(&0.0))
        .fold(0.0, f64::max);
    let relinearized = (0.15 / whole.max(1e-9)).max(step / 2500.0);
    let count = (2.0 * step / relinearized) as usize;
    let best = |first_hz: f64, by_hz: f64, count: usize| {
        coherent(series, first_hz, by_hz, count)
            .into_iter()
            .enumerate()
            .map(|(k, power)| (first_hz + k as f64 * by_hz, power))
            .filter(|(hz, _)| *hz > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|best| best.0)
    };
    let near = best(coarse - step, relinearized, count + 1)?;
    // Half a step off turns the phase by a quarter of a radian from end to end: lines beside it would stand for that.
    best(
        near - relinearized,
        relinearized / FINER as f64,
        2 * FINER + 1,
    )
}

/// Parts of a step that the strongest frequency is told to. Derived from sinc²: a twentieth of a step of 0.3 turns over the piece
/// loses 0.0002 of the power.
const FINER: usize = 20;

/// The strongest frequency of a group, how far it stands above the median power, and the grid's step.
fn peak(series: &[Series], group: &[Piece]) -> Option<(f64, f64, f64)> {
    let longest = group.iter().map(|p| p.length_s).fold(0.0, f64::max);
    let top = 0.5 / group[0].interval_s;
    let step = (0.3 / longest).max(top / TRIALS as f64);
    let trials = (top / step) as usize;
    let powers: Vec<f64> = powers(series, group, step, trials)
        .into_iter()
        .skip(SLOWEST)
        .collect();
    let middle = crate::algebra::statistics::median(&mut powers.clone())?.max(1e-12);
    let (at, top) = powers
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))?;
    let pieces = group.len() as f64;
    (*top > 5.0 * middle && *top > 30.0 + 2.0 * pieces)
        .then(|| ((at + SLOWEST) as f64 * step, top / middle, step))
}

/// Takes a line out of a series, one phase throughout.
pub fn subtract(one: &mut Series, hz: f64) {
    let n = one.t_s.len().max(1) as f64;
    let (mut s, mut c) = (0.0, 0.0);
    for (t, v) in one.t_s.iter().zip(&one.value) {
        let (a, b) = (TAU * hz * t).sin_cos();
        s += a * v;
        c += b * v;
    }
    for (t, v) in one.t_s.iter().zip(one.value.iter_mut()) {
        let (a, b) = (TAU * hz * t).sin_cos();
        *v -= 2.0 * (s * a + c * b) / n;
    }
}

/// Lines nearer than this share of their frequency are one. Derived from what a recording tells: over 100 s a line of 100 Hz is
/// told to 1e-5 of itself by a tenth of a turn.
const SAME_LINE: f64 = 1.0e-5;

/// Adds to `list` the lines that are not in it.
pub fn add_lines(list: &mut Vec<f64>, more: Vec<f64>) {
    for hz in more {
        if list
            .iter()
            .all(|known| (known / hz - 1.0).abs() > SAME_LINE)
        {
            list.push(hz);
        }
    }
}

/// Lines of the coordination sensor and of the segments, Hz.
pub fn lines_of(linearized: &LinearizedRecording, residuals: &Residuals) -> (Vec<f64>, Vec<f64>) {
    let o = linearized.observations;
    let pick = |channel: usize| -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let mut out = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..residuals.sample.len() {
            if residuals.channel[k] == channel {
                let i = residuals.sample[k];
                out.0.push(o.t_s[i] - o.t_s[0]);
                out.1.push(residuals.white[k]);
                out.2.push(o.stretch[i]);
            }
        }
        out
    };
    let search = |channels: &[usize]| {
        let data: Vec<_> = channels
            .iter()
            .map(|c| pick(*c))
            .filter(|d| d.0.len() > 50)
            .collect();
        let mut series: Vec<Series> = data
            .iter()
            .map(|d| Series {
                t_s: &d.0,
                value: d.1.clone(),
                stretch: &d.2,
            })
            .collect();
        if series.is_empty() {
            Vec::new()
        } else {
            lines_hz(&mut series)
        }
    };
    (search(&[1, 2]), search(&[0, 3, 4, 5, 6]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a second at a thousand a second tells a line to a tenth of a turn of it; the few samples at each of many poses after that tell
    /// it by as much better as they go on longer.
    #[test]
    fn a_line_of_a_short_run_is_told_by_the_poses_beside_it() {
        let (hz, length_s) = (19.1512, 200.0);
        let run = (0..500).map(|i| (f64::from(i) * 1.0e-3, 0));
        let pose =
            |k: usize| (0..4).map(move |i| (1.0 + k as f64 * 0.4 + f64::from(i) * 1.0e-3, 1 + k));
        let poses = (0..(length_s / 0.4) as usize).flat_map(pose);
        let (t_s, stretch): (Vec<f64>, Vec<usize>) = run.chain(poses).unzip();
        let value = t_s.iter().map(|t| 3.0 * (TAU * hz * t + 0.7).sin());
        let series = Series {
            t_s: &t_s,
            value: value.collect(),
            stretch: &stretch,
        };
        let found = lines_hz(&mut [series]);
        assert!((found[0] - hz).abs() < 0.1 / length_s, "{found:?}");
    }
}
