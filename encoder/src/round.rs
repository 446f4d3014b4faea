//! The radius of a recording's pair: offset, gain and angle of its channels, with their scatter from period to period.

use crate::asked::Refusal;
use crate::combined::{Combined, Piece, combined};
use crate::input::{Input, Phases};
use courier_signal::encoder::{CIRCLE_UNKNOWNS, Circle};
use courier_signal::quadrature::PairCorrection;
use nalgebra::{DMatrix, DVector};

/// Readings a period that are entered: alike from all of the period, also where the motion rests. By definition as many as the
/// device takes (`signal/src/encoder/learner.rs`).
const PER_PERIOD: f64 = 64.0;
/// Steps of the correction. Derived from their quadratic convergence: each leaves the square of what there was, and an offset of
/// half the amplitude is below a count after five.
const STEPS: usize = 8;

/// What was found.
#[derive(Clone, Debug)]
pub(crate) struct Rounded {
    /// In counts of the signal path.
    pub pair: PairCorrection,
    pub amplitude: f64,
    /// Standard deviations of offsets (counts), gain and angle (rad).
    pub deviations: [f64; 4],
    /// `[a_n, b_n]` of orders 3 and 4 of the radius, shares, and the standard deviation of each.
    pub orders: [([f64; 2], f64); 2],
    /// Counts of the recording over those of the signal path.
    pub scale: f64,
}

/// The correction that makes the pair round; none where no counts were logged.
pub(crate) fn round(input: &Input) -> Result<Option<Rounded>, Refusal> {
    if input.counts.is_empty() {
        return Ok(None);
    }
    let mut pair = PairCorrection::default();
    for _ in 0..STEPS {
        let phases = input.phases(Some(&pair))?;
        let mut circle = Circle::new();
        for row in places(&phases).into_iter().flatten() {
            if let Some(reading) = &phases.samples[row].reading {
                circle.enter(reading).map_err(|_| Refusal::Circle)?;
            }
        }
        let round = circle.solve().map_err(|_| Refusal::Circle)?;
        pair = round.correction(&pair);
    }
    let phases = input.phases(Some(&pair))?;
    let (told, nominal) = told(&phases).ok_or(Refusal::Circle)?;
    let mean = told.values[0];
    let amplitude = mean * nominal;
    let share = |index: usize| told.deviation(index) / mean;
    let order = |n: usize| {
        let at = 2 * n - 1;
        (
            [told.values[at] / mean, told.values[at + 1] / mean],
            told.deviation_of_pair(at) / mean,
        )
    };
    Ok(Some(Rounded {
        amplitude,
        // As `Round::correction` goes from orders to constants.
        deviations: [
            share(1) * amplitude,
            share(2) * amplitude * f64::from(pair.gain),
            2.0 * share(4) * f64::from(pair.gain),
            2.0 * share(3),
        ],
        orders: [order(3), order(4)],
        pair,
        scale: input.scale(),
    }))
}

/// The samples that count, period by period.
fn places(phases: &Phases) -> Vec<Vec<usize>> {
    let mut periods = Vec::new();
    for piece in &phases.pieces {
        let (mut rows, mut last, mut gone) = (Vec::new(), f64::NAN, 0.0);
        for row in piece.clone() {
            let moved = (phases.samples[row].place - last).abs();
            if moved < 1.0 / PER_PERIOD {
                continue;
            }
            last = phases.samples[row].place;
            gone += if moved.is_nan() { 0.0 } else { moved };
            rows.push(row);
            if gone >= 1.0 {
                periods.push(std::mem::take(&mut rows));
                gone = 0.0;
            }
        }
        if rows.len() > 1 {
            periods.push(rows);
        }
    }
    periods
}

/// All periods together, and the radius that they are written in.
fn told(phases: &Phases) -> Option<(Combined, f64)> {
    let nominal = phases.samples.first()?.amplitude.max(1.0);
    let pieces: Vec<Piece> = places(phases)
        .iter()
        .filter_map(|rows| {
            let mut circle = Circle::with_nominal(nominal as f32);
            for row in rows {
                circle.enter(phases.samples[*row].reading.as_ref()?).ok()?;
            }
            let triangle = &circle.estimator.rows;
            Some(Piece {
                rows: DMatrix::from_fn(CIRCLE_UNKNOWNS, CIRCLE_UNKNOWNS, |i, j| {
                    f64::from(triangle.entry(i, j))
                }),
                right: DVector::from_fn(CIRCLE_UNKNOWNS, |i, _| {
                    f64::from(triangle.right_hand_side(i))
                }),
            })
        })
        .collect();
    Some((combined(&pieces)?, nominal))
}
