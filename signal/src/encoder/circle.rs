//! What the radius tells: offset, gain and angle of the channels, and orders 3 and 4 of its own.

use super::pair::Reading;
use crate::lsq::{Estimator, RowError, SolveError, packed_len};
use crate::math::{atan2_turns, sincos_turns, sqrt};
use crate::model::Unit;
use crate::quadrature::PairCorrection;
use core::f32::consts::TAU;

/// Highest order of the radius. A definition: offsets make order 1, gain and angle 2, third harmonics 2 and 4.
pub const CIRCLE_ORDERS: usize = 4;
/// Unknowns of a row: the mean, then sine and cosine of each order.
pub const CIRCLE_UNKNOWNS: usize = 1 + 2 * CIRCLE_ORDERS;
const PACKED: usize = packed_len(CIRCLE_UNKNOWNS);

/// Least squares of `radius / nominal = mean + sum over n of a_n sin(n phi) + b_n cos(n phi)`, row by row.
#[derive(Clone, Debug)]
pub struct Circle {
    /// The rows, for whoever adds several up.
    pub estimator: Estimator<CIRCLE_UNKNOWNS, PACKED>,
    /// The radius that rows are written in: that of the first reading, or stated.
    nominal_counts: f32,
}

impl Default for Circle {
    fn default() -> Self {
        Self::new()
    }
}

/// The radius over a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Mean radius, counts of the sine channel.
    pub amplitude_counts: f32,
    /// `[a_n, b_n]` of orders 1 to 4 as shares of the mean.
    pub orders: [[f32; 2]; CIRCLE_ORDERS],
    /// Standard deviations of these, by the scatter of the radius.
    pub deviations: [[f32; 2]; CIRCLE_ORDERS],
}

impl Circle {
    /// Without a row.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            estimator: Estimator::new(CIRCLE_UNKNOWNS),
            nominal_counts: 0.0,
        }
    }

    /// The same with rows in shares of a radius that is stated, counts above 0: those of several circles then add up.
    #[must_use]
    pub const fn with_nominal(counts: f32) -> Self {
        Self {
            nominal_counts: counts,
            ..Self::new()
        }
    }

    /// The functions of a row.
    #[must_use]
    pub fn row(phase: Unit) -> [f32; CIRCLE_UNKNOWNS] {
        let mut row = [1.0; CIRCLE_UNKNOWNS];
        let mut multiple = Unit::ZERO;
        for pair in row[1..].as_chunks_mut::<2>().0 {
            multiple = multiple.plus(phase);
            *pair = [multiple.sine, multiple.cosine];
        }
        row
    }

    /// Enters a reading. Readings should come from all of the period alike: take one each time that the phase has moved on.
    ///
    /// # Errors
    /// Never for a reading of an [`Encoder`](super::Encoder): all of it is finite.
    pub fn enter(&mut self, reading: &Reading) -> Result<(), RowError> {
        if self.nominal_counts == 0.0 {
            self.nominal_counts = reading.amplitude_counts.max(1.0);
        }
        let radius = reading.amplitude_counts / self.nominal_counts;
        self.estimator
            .rows
            .enter(&Self::row(reading.phase), radius)?;
        Ok(())
    }

    /// Solves for the radius. Background only.
    ///
    /// # Errors
    /// No rows, or rows that do not tell all orders: the period was not gone through.
    pub fn solve(&mut self) -> Result<Round, SolveError> {
        let solution = self.estimator.solve_equilibrated()?;
        let mean = solution.values[0];
        if solution.rank < CIRCLE_UNKNOWNS || mean <= 0.0 {
            return Err(SolveError::Empty);
        }
        let pairs = |values: &[f32; CIRCLE_UNKNOWNS]| {
            core::array::from_fn(|n| [1, 2].map(|part| values[2 * n + part] / mean))
        };
        Ok(Round {
            amplitude_counts: mean * self.nominal_counts,
            orders: pairs(&solution.values),
            deviations: pairs(&solution.deviations),
        })
    }

    /// Forgets all rows.
    pub fn reset(&mut self) {
        self.estimator.reset(CIRCLE_UNKNOWNS);
        self.nominal_counts = 0.0;
    }
}

impl Round {
    /// The correction that makes orders 1 and 2 of the radius vanish to first order, where `old` was in force: the signals are taken to
    /// have no second and third harmonic. Repeat with new readings (or the old ones, corrected anew) where it is not small.
    #[must_use]
    pub fn correction(&self, old: &PairCorrection) -> PairCorrection {
        // Centre of the circle in the corrected plane, and back to raw counts.
        let centre = self.orders[0].map(|share| share * self.amplitude_counts);
        let (sine, cosine) = sincos_turns(old.angle_rad / TAU);
        let tangent = sine / cosine;
        let scale = old.gain * cosine;
        // r / A = 1 + g / 2 + g / 2 cos 2 phi - d / 2 sin 2 phi where the cosine channel is (1 + g) cos(phi + d).
        let [skew, gain] = [-2.0 * self.orders[1][0], 2.0 * self.orders[1][1]];
        let (sine, cosine) = sincos_turns(skew / TAU);
        let x = (1.0 + gain) * cosine;
        let y = (1.0 + gain) * sine + tangent;
        PairCorrection {
            offset_counts: [
                old.offset_counts[0] + centre[0],
                old.offset_counts[1] + (centre[1] - centre[0] * tangent) * scale,
            ],
            gain: scale * sqrt(x * x + y * y),
            angle_rad: TAU * atan2_turns(y, x),
        }
    }
}
