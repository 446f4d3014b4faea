//! Single poles and eccentricity: what repeats with the turn and not with the period.

use crate::answer::Turn;
use crate::input::Phases;
use crate::stretches::ways;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::Range;

/// Polynomials of time that the motion of a stretch is tried as: the one that foretells best is taken.
const DEGREES: [usize; 4] = [3, 5, 8, 12];
/// Turns of a stretch. Derived from what is repeated: with fewer than two nothing is, and a polynomial of twelve over more than
/// four bends less than one of five does over two.
const TURNS: [f64; 2] = [2.0, 4.0];
/// Most stretches. A bound on the work: the longest ones tell most.
const MOST_STRETCHES: usize = 8;
/// Highest order as a multiple of the periods. Derived from poles that differ, which show about the period's own orders, of which
/// the second is the largest that sensors show (`docs/effects.md`), and a period's orders more on either side.
const PER_PERIOD: f64 = 4.0;
/// Most orders. A bound on the work, which grows with their square: what is higher is left.
const MOST_ORDERS: f64 = 128.0;
/// Fewest samples of the highest order's wave. Derived from the sampling theorem, with a factor of four for noise.
const SAMPLES_A_WAVE: f64 = 8.0;
/// Parts of the periods that are foretold by the others.
/// A bound on the work: each is a fit of its own.
const FOLDS: usize = 3;

/// Normal equations of one part: every stretch's polynomials, then all orders.
struct Fold {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    rows: usize,
}

/// What is tried.
#[derive(Clone, Copy, Debug)]
struct Model {
    degree: usize,
    orders: usize,
    /// The noise's square over that of a coefficient's expected size, times the rows that are alike.
    prior: f64,
}

/// Fits orders of the turn, as many as foretell periods that they were not fitted to best; none where no number of them does better
/// than none.
pub(crate) fn turn(phases: &Phases, periods: u32) -> Option<Turn> {
    let turn = f64::from(periods);
    let stretches = cut(phases, turn);
    let travelled: f64 = stretches.iter().map(|range| travel(phases, range)).sum();
    let rows: usize = stretches.iter().map(ExactSizeIterator::len).sum();
    let per_period = rows as f64 / travelled;
    let most = (PER_PERIOD * turn)
        .min(MOST_ORDERS)
        .min(per_period * turn / SAMPLES_A_WAVE);
    if stretches.is_empty() || most < 1.0 {
        return None;
    }
    let folds = folds(phases, &stretches, periods, most as usize);
    let foretold = |model: Model| foretold(&folds, stretches.len(), model);
    let best = |prior: f64, least: usize| {
        let orders = std::iter::once(0)
            .chain(numbers(most as usize))
            .filter(|n| *n >= least);
        let models = orders.flat_map(|orders| {
            DEGREES.map(|degree| Model {
                degree,
                orders,
                prior,
            })
        });
        models
            .filter_map(|model| Some((foretold(model)?, model)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let before = DEGREES
        .into_iter()
        .filter_map(|degree| {
            foretold(Model {
                degree,
                orders: 0,
                prior: 1.0,
            })
        })
        .min_by(f64::total_cmp)?;
    // Each order is expected to be as large as all that is seen, and what is left of neighbours to be alike over a period: a low order
    // that the motion's polynomial can hide is then not made up.
    let (first, _) = best(per_period, 1)?;
    let (after, model) = best(per_period * (first / before).powi(2), 1)?;
    if after >= before {
        return None;
    }
    let whole = sum(folds.iter(), stretches.len(), model);
    let values = fit(whole)?;
    let start = stretches.len() * (model.degree + 1);
    Some(Turn {
        periods,
        orders: (0..model.orders)
            .map(|n| [values[start + 2 * n], values[start + 2 * n + 1]])
            .collect(),
        before_turns: before,
        after_turns: after,
        stretches: stretches.len(),
        index: None,
    })
}

/// The longest ways in stretches of two to four turns.
fn cut(phases: &Phases, turn: f64) -> Vec<Range<usize>> {
    let mut ways = ways(phases);
    ways.sort_by(|a, b| travel(phases, b).total_cmp(&travel(phases, a)));
    let mut found = Vec::new();
    for way in ways {
        let turns = travel(phases, &way) / turn;
        if turns < TURNS[0] {
            break;
        }
        let parts = (turns / TURNS[1]).ceil();
        let mut start = way.start;
        for row in way.clone() {
            let gone = travel(phases, &(start..row + 1)) / turn;
            if gone >= turns / parts || row + 1 == way.end && gone >= TURNS[0] {
                found.push(start..row + 1);
                start = row;
            }
        }
    }
    found.truncate(MOST_STRETCHES);
    found
}

fn travel(phases: &Phases, range: &Range<usize>) -> f64 {
    (phases.samples[range.end - 1].place - phases.samples[range.start].place).abs()
}

/// One order after the other, then a quarter more each time, and the most.
fn numbers(most: usize) -> Vec<usize> {
    let mut numbers: Vec<usize> =
        std::iter::successors(Some(1_usize), |n| Some((n + 1).max(n * 5 / 4)))
            .take_while(|n| *n < most)
            .collect();
    numbers.push(most);
    numbers
}

/// A period of each turn goes into another part, so that each part has every pole, and every time.
fn folds(phases: &Phases, stretches: &[Range<usize>], periods: u32, orders: usize) -> Vec<Fold> {
    let drift = DEGREES[DEGREES.len() - 1] + 1;
    let unknowns = stretches.len() * drift + 2 * orders;
    let empty = || Fold {
        matrix: DMatrix::zeros(unknowns, unknowns),
        right: DVector::zeros(unknowns),
        square: 0.0,
        rows: 0,
    };
    let mut folds: Vec<Fold> = (0..FOLDS).map(|_| empty()).collect();
    for (number, range) in stretches.iter().enumerate() {
        let start = phases.samples[range.start].place;
        for (part, fold) in folds.iter_mut().enumerate() {
            let of_part = |row: &usize| {
                let period = phases.samples[*row].place.floor() as i64;
                let turn = period.div_euclid(i64::from(periods));
                (period + turn).rem_euclid(FOLDS as i64) as usize == part
            };
            let rows: Vec<usize> = range.clone().filter(of_part).collect();
            let [begin, end] = [range.start, range.end - 1].map(|row| phases.t_s[row]);
            let time = |row: usize| (2.0 * phases.t_s[row] - begin - end) / (end - begin);
            let columns = DMatrix::from_fn(rows.len(), drift + 2 * orders, |row, column| {
                if column < drift {
                    return (column as f64 * time(rows[row]).clamp(-1.0, 1.0).acos()).cos();
                }
                let order = (column - drift) / 2 + 1;
                let angle = TAU
                    * order as f64
                    * (phases.samples[rows[row]].place / f64::from(periods)).fract();
                -if (column - drift) % 2 == 0 {
                    angle.sin()
                } else {
                    angle.cos()
                }
            });
            let right =
                DVector::from_fn(rows.len(), |row, _| phases.samples[rows[row]].place - start);
            let at = |column: usize| {
                if column < drift {
                    number * drift + column
                } else {
                    column - drift + stretches.len() * drift
                }
            };
            let (products, sides) = (columns.tr_mul(&columns), columns.tr_mul(&right));
            for i in 0..columns.ncols() {
                fold.right[at(i)] += sides[i];
                (0..columns.ncols()).for_each(|j| fold.matrix[(at(i), at(j))] += products[(i, j)]);
            }
            fold.square += right.norm_squared();
            fold.rows += rows.len();
        }
    }
    folds
}

/// The unknowns that a model has of all.
fn places(stretches: usize, model: Model) -> Vec<usize> {
    let drift = DEGREES[DEGREES.len() - 1] + 1;
    let polynomials = (0..stretches)
        .flat_map(|stretch| (0..=model.degree).map(move |power| stretch * drift + power));
    polynomials
        .chain((0..2 * model.orders).map(|column| stretches * drift + column))
        .collect()
}

/// The folds' equations in a model's unknowns, with its prior.
fn sum<'a>(
    folds: impl Iterator<Item = &'a Fold>,
    stretches: usize,
    model: Model,
) -> (DMatrix<f64>, DVector<f64>) {
    let at = places(stretches, model);
    let free = stretches * (model.degree + 1);
    let mut matrix = DMatrix::from_fn(at.len(), at.len(), |i, j| {
        if i == j && i >= free {
            model.prior
        } else {
            0.0
        }
    });
    let mut right = DVector::zeros(at.len());
    for fold in folds {
        matrix += DMatrix::from_fn(at.len(), at.len(), |i, j| fold.matrix[(at[i], at[j])]);
        right += DVector::from_fn(at.len(), |i, _| fold.right[at[i]]);
    }
    (matrix, right)
}

fn fit((matrix, right): (DMatrix<f64>, DVector<f64>)) -> Option<DVector<f64>> {
    Some(matrix.cholesky()?.solve(&right))
}

/// Root of the mean square of what the other folds leave of each, turns.
fn foretold(folds: &[Fold], stretches: usize, model: Model) -> Option<f64> {
    let at = places(stretches, model);
    let (mut squares, mut rows) = (0.0, 0);
    for (left_out, fold) in folds.iter().enumerate() {
        let others = folds
            .iter()
            .enumerate()
            .filter(|(place, _)| *place != left_out)
            .map(|(_, other)| other);
        let values = fit(sum(others, stretches, model))?;
        let matrix = DMatrix::from_fn(at.len(), at.len(), |i, j| fold.matrix[(at[i], at[j])]);
        let right = DVector::from_fn(at.len(), |i, _| fold.right[at[i]]);
        squares += fold.square - 2.0 * values.dot(&right) + values.dot(&(matrix * &values));
        rows += fold.rows;
    }
    Some((squares.max(0.0) / rows as f64).sqrt())
}
