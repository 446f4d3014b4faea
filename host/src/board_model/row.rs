//! A term of the board's error model with its coefficients, and how much it does in usual work.

use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{Multiplier, Term};
use diagnosis::linearization::baseline::ORDERS;

/// Half a degree to either side, rad: as in the paper's self-calibration (3.1.2).
pub(super) const USUAL_ANGLE_RAD: f64 = 8.727e-3;
/// A fly-by's.
const USUAL_SPEED_M_S: f64 = 0.1;
/// A morning's.
const USUAL_WARMING_K: f64 = 5.0;

/// A term with the coefficients of all segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Term.
    pub(super) term: Term,
    /// `[segment][sine, cosine]`, m, at an angle, speed and warmth of 1.
    pub(super) coefficients: [[f64; 2]; SEGMENTS],
}

impl Row {
    /// All coefficients zero.
    pub(super) fn empty(term: Term) -> Self {
        Self {
            term,
            coefficients: [[0.0; 2]; SEGMENTS],
        }
    }

    /// Whether it is of the own phase alone.
    pub(super) fn is_own(&self) -> bool {
        self.term == Term::own(self.term.own_order)
    }

    /// Whether equation (3) has it.
    pub(super) fn is_equation_3(&self) -> bool {
        self.is_own() && ORDERS.contains(&usize::from(self.term.own_order))
    }

    /// Largest correction that it makes, metres, at the angle, speed and temperature of usual work.
    pub(super) fn size_m(&self) -> f64 {
        let all = self.coefficients.as_flattened();
        let largest = all.iter().fold(0.0, |largest: f64, c| c.abs().max(largest));
        let factor = match self.term.multiplier {
            Multiplier::None | Multiplier::Direction => 1.0,
            Multiplier::Speed => USUAL_SPEED_M_S,
            Multiplier::Temperature => USUAL_WARMING_K,
        };
        largest * factor * USUAL_ANGLE_RAD.powi(i32::from(self.term.theta_power))
    }
}
