//! The angle's orders by the smoothness of the motion, told from what the motion itself does with the phase.
//!
//! A stretch at speed v tells, order by order, the sum of
//!
//! * the sensor's error, the same at every speed and both ways;
//! * a ripple of the true motion that a force locked to the phase makes: of an inertia it is as large as `1 / v²`, and coasting shows
//!   the same;
//! * what reverses with the direction: friction, hysteresis, a delay.
//!
//! The second is told from the first where there are several speeds, the third where there are both directions. Where there are
//! not, the sum is taken for the sensor's, and the answer says so.

use crate::asked::Refusal;
use crate::combined::{Combined, Piece, combined};
use crate::input::Phases;
use crate::stretches::{Told, ranges, told};
use courier_signal::encoder::{ORDERS, PERIODS};
use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Lengths of a stretch that are tried, periods: the device's own, then a shorter one for short recordings. Below one period the lowest order
/// is not told from a cubic of time; a quarter more is a choice.
const LENGTHS: [f64; 2] = [PERIODS as f64, 1.25];
/// Fewest stretches. Derived from the degrees of freedom: the scatter of four, which says how well the errors are known, has
/// three.
const LEAST_STRETCHES: usize = 4;
/// Chance of naming a ripple or a part that reverses where there is none, for each order. A prior: 8 orders then err in 1 of 125
/// recordings.
const RIPPLE_CHANCE: f64 = 1.0e-3;
/// Chance of applying an order that is none (Fisher 1925). Its price is small: what is applied is then of the size of its
/// deviation.
const ORDER_CHANCE: f64 = 0.05;
/// Speeds told apart: the squares of the slower and the faster tenth differ by so much. Derived from a ripple that goes with the
/// square: half of it is seen in the difference.
const SPEED_SQUARES: f64 = 2.0;

/// Noise over the median stretch's beyond which the motion was no cubic there: a start, a stop, a blow. Derived from chi-square:
/// among stretches of white noise that is known to a quarter none is four times as loud.
const LOUD: f64 = 4.0;

/// What the motion tells.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// The fit: the error's columns, then those of `ripples`, then those of `reversing`.
    fit: Combined,
    /// Orders (from 0) with a ripple of the motion, and with a part that reverses.
    pub ripples: Vec<usize>,
    pub reversing: Vec<usize>,
    /// Whether the speeds tell a ripple from an error, and the directions what reverses.
    pub speeds_tell: bool,
    pub directions_tell: bool,
    /// Stretches and the periods of each.
    pub stretches: usize,
    pub periods: f64,
    /// Slowest and fastest tenth, periods a second.
    pub speeds: [f64; 2],
    /// The speed that ripples are stated at: the root of the inverse mean of `1 / v²`.
    pub ripple_speed: f64,
    /// What is left within the median stretch, rms turns.
    pub noise: f64,
}

/// Fits the stretches of a recording.
pub(crate) fn motion(phases: &Phases) -> Result<Motion, Refusal> {
    let (periods, stretches) = cut(phases)?;
    let mut speeds: Vec<f64> = stretches.iter().map(|told| told.speed.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    let at = |share: f64| speeds[(share * (speeds.len() - 1) as f64).round() as usize];
    let extremes = [at(0.1), at(0.9)];
    let inverse = speeds.iter().map(|v| v.powi(-2)).sum::<f64>() / speeds.len() as f64;
    let ripple_speed = inverse.powf(-0.5);
    let columns = Columns {
        stretches: &stretches,
        ripple_speed,
    };
    let speeds_tell = (extremes[1] / extremes[0]).powi(2) >= SPEED_SQUARES;
    let backwards = stretches.iter().filter(|told| told.speed < 0.0).count();
    let directions_tell = backwards.min(stretches.len() - backwards) >= LEAST_STRETCHES / 2;
    let all: Vec<usize> = (0..ORDERS).collect();
    let mut ripples = Vec::new();
    if speeds_tell {
        ripples = columns.found(&all, &[], 0).unwrap_or_default();
    }
    let mut reversing = Vec::new();
    if directions_tell {
        reversing = columns
            .found(&ripples, &all, ripples.len())
            .unwrap_or_default();
    }
    let fit = columns.fit(&ripples, &reversing).or_else(|| {
        (ripples, reversing) = (Vec::new(), Vec::new());
        columns.fit(&[], &[])
    });
    let fit = fit.ok_or(Refusal::Motion {
        found: stretches.len(),
        periods,
        wanted: LEAST_STRETCHES,
    })?;
    Ok(Motion {
        fit,
        ripples,
        reversing,
        speeds_tell,
        directions_tell,
        stretches: stretches.len(),
        periods,
        speeds: extremes,
        ripple_speed,
        noise: median_noise(&stretches),
    })
}

fn cut(phases: &Phases) -> Result<(f64, Vec<Told>), Refusal> {
    let mut found = 0;
    for periods in LENGTHS {
        let stretches = without_loud(told(phases, &ranges(phases, periods)));
        found = stretches.len();
        if found >= LEAST_STRETCHES {
            return Ok((periods, stretches));
        }
    }
    Err(Refusal::Motion {
        found,
        periods: LENGTHS[1],
        wanted: LEAST_STRETCHES,
    })
}

fn without_loud(mut stretches: Vec<Told>) -> Vec<Told> {
    let noise = median_noise(&stretches);
    stretches.retain(|told| told.noise <= LOUD * noise);
    stretches
}

fn median_noise(stretches: &[Told]) -> f64 {
    let mut noises: Vec<f64> = stretches.iter().map(|told| told.noise).collect();
    noises.sort_by(f64::total_cmp);
    noises.get(noises.len() / 2).copied().unwrap_or_default()
}

struct Columns<'a> {
    stretches: &'a [Told],
    ripple_speed: f64,
}

impl Columns<'_> {
    fn fit(&self, ripples: &[usize], reversing: &[usize]) -> Option<Combined> {
        let pieces: Vec<Piece> = self
            .stretches
            .iter()
            .map(|told| {
                let groups = [
                    ((0..ORDERS).collect(), 1.0),
                    (ripples.to_vec(), (self.ripple_speed / told.speed).powi(2)),
                    (reversing.to_vec(), told.speed.signum()),
                ];
                let columns: Vec<_> = groups
                    .iter()
                    .flat_map(|(orders, factor)| {
                        orders.iter().flat_map(move |n| {
                            [2 * n, 2 * n + 1].map(|column| told.rows.column(column) * *factor)
                        })
                    })
                    .collect();
                Piece {
                    rows: DMatrix::from_columns(&columns),
                    right: told.right.clone(),
                }
            })
            .collect();
        combined(&pieces)
    }

    /// Which of the orders in the last group, after `before` others beside the error's, are more than chance.
    fn found(&self, ripples: &[usize], reversing: &[usize], before: usize) -> Option<Vec<usize>> {
        let fit = self.fit(ripples, reversing)?;
        let asked = if reversing.is_empty() {
            ripples
        } else {
            reversing
        };
        let found = asked.iter().enumerate().filter(|(place, _)| {
            let at = 2 * (ORDERS + before + place);
            beyond_chance(&fit, at, RIPPLE_CHANCE)
        });
        Some(found.map(|(_, order)| *order).collect())
    }
}

fn beyond_chance(fit: &Combined, at: usize, chance: f64) -> bool {
    let freedom = (fit.pieces - 1) as f64;
    FisherSnedecor::new(2.0, freedom).is_ok_and(|f| 1.0 - f.cdf(fit.ratio_of_pair(at)) < chance)
}

impl Motion {
    /// `[a_n, b_n]` and their deviation, turns.
    pub fn order(&self, order: usize) -> ([f64; 2], f64) {
        self.pair(2 * order)
    }

    /// Whether it is more than chance.
    pub fn is_seen(&self, order: usize) -> bool {
        beyond_chance(&self.fit, 2 * order, ORDER_CHANCE)
    }

    /// The same of an order's ripple at [`Motion::ripple_speed`]; none where there is none.
    pub fn ripple(&self, order: usize) -> Option<([f64; 2], f64)> {
        let place = self.ripples.iter().position(|n| *n == order)?;
        Some(self.pair(2 * (ORDERS + place)))
    }

    /// The same of what reverses.
    pub fn reverses(&self, order: usize) -> Option<([f64; 2], f64)> {
        let place = self.reversing.iter().position(|n| *n == order)?;
        Some(self.pair(2 * (ORDERS + self.ripples.len() + place)))
    }

    fn pair(&self, at: usize) -> ([f64; 2], f64) {
        (
            [self.fit.values[at], self.fit.values[at + 1]],
            self.fit.deviation_of_pair(at),
        )
    }

    /// What is to be added: the orders that are seen.
    pub fn harmonics(&self) -> Vec<[f64; 2]> {
        (0..ORDERS)
            .map(|n| {
                if self.is_seen(n) {
                    self.order(n).0
                } else {
                    [0.0; 2]
                }
            })
            .collect()
    }
}
