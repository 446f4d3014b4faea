//! A recording's motion in stretches of equal length, each with what it tells of the angle's error: the device's own rows.

use crate::input::Phases;
use courier_signal::encoder::{COLUMNS, Stretch};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Most rows of a period. A bound on the work: more tell little more, since noise is then no longer independent from row to row.
const MOST_PER_PERIOD: f64 = 512.0;
/// A way back of so much, periods, ends a stretch. A prior: noise and errors go back by less.
const BACK: f64 = 0.25;
/// Smallest noise that a stretch is believed to have, turns. By definition as the device has it: what f32 leaves of a place of
/// two periods (`signal/src/encoder/learner.rs`).
const LEAST_NOISE: f64 = 5.0e-7;

/// What one stretch tells.
#[derive(Clone, Debug)]
pub(crate) struct Told {
    /// Equations between the error's unknowns: turns over the stretch's noise.
    pub rows: DMatrix<f64>,
    pub right: DVector<f64>,
    /// Mean speed, periods a second; negative backwards.
    pub speed: f64,
    /// What is left of its places, rms turns.
    pub noise: f64,
}

/// Where the motion goes one way without a break.
pub(crate) fn ways(phases: &Phases) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for piece in &phases.pieces {
        let place = |row: usize| phases.samples[row].place;
        // From the last turning point, and the farthest that was reached since.
        let (mut start, mut farthest) = (piece.start, piece.start);
        for row in piece.clone() {
            let (gone, moved) = (place(farthest) - place(start), place(row) - place(start));
            if moved.abs() > gone.abs() && moved * gone >= 0.0 {
                farthest = row;
            } else if (moved - gone).abs() > BACK {
                found.push(start..farthest + 1);
                (start, farthest) = (farthest, row);
            }
        }
        found.push(start..farthest + 1);
    }
    found
}

/// Stretches of `periods` one way.
pub(crate) fn ranges(phases: &Phases, periods: f64) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for way in ways(phases) {
        let mut start = way.start;
        for row in way {
            if (phases.samples[row].place - phases.samples[start].place).abs() >= periods {
                found.push(start..row + 1);
                start = row;
            }
        }
    }
    found
}

/// What each of them tells; those with too few samples are left out.
pub(crate) fn told(phases: &Phases, ranges: &[Range<usize>]) -> Vec<Told> {
    ranges
        .iter()
        .filter_map(|range| one(phases, range.clone()))
        .collect()
}

fn one(phases: &Phases, range: Range<usize>) -> Option<Told> {
    let (first, last) = (range.start, range.end - 1);
    let [begin, end] = [first, last].map(|row| phases.t_s[row]);
    let (middle, half) = (0.5 * (begin + end), 0.5 * (end - begin));
    let travel = phases.samples[last].place - phases.samples[first].place;
    let mut stretch = Stretch::new(COLUMNS / 2);
    let mut taken = f64::NAN;
    for row in range {
        let sample = &phases.samples[row];
        let place = sample.place - phases.samples[first].place;
        if (place - taken).abs() < 1.0 / MOST_PER_PERIOD {
            continue;
        }
        taken = place;
        let time = (phases.t_s[row] - middle) / half;
        stretch
            .enter(time as f32, place as f32, sample.phase)
            .ok()?;
    }
    // Half as many rows again as unknowns: the noise is then known to a quarter or so.
    if (stretch.rows() as usize) < 3 * (COLUMNS + 4) / 2 {
        return None;
    }
    let noise = f64::from(stretch.noise_turns()?).max(LEAST_NOISE);
    let equations: Vec<([f32; COLUMNS], f32)> =
        (0..COLUMNS).map(|index| stretch.equation(index)).collect();
    Some(Told {
        rows: DMatrix::from_fn(COLUMNS, COLUMNS, |i, j| {
            f64::from(equations[i].0[j]) / noise
        }),
        right: DVector::from_fn(COLUMNS, |i, _| f64::from(equations[i].1) / noise),
        speed: travel / (end - begin),
        noise,
    })
}
