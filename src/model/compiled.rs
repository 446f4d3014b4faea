//! The error model in machine units: equations (3) and (9) dense, every other row in a bounded list.

use super::basis::{Basis, Unit, equation_3_orders};
use super::{ErrorModel, MAX_TERMS, Term, TermCoefficients};
use crate::frame::SEGMENTS;
use heapless::Vec;

/// Own orders of the dense part.
const DENSE_ORDERS: [u8; 4] = [1, 2, 4, 6];

/// One segment's coefficients, turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DenseSegment {
    constant: f32,
    own: [[f32; 2]; 4],
    lateral: [f32; 2],
}

/// An [`ErrorModel`] as the interrupt applies it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CompiledModel {
    pub dense: [DenseSegment; SEGMENTS],
    /// Whether any coefficient of equation (9) is in use.
    pub lateral: bool,
    extra: Vec<(Term, TermCoefficients), MAX_TERMS>,
    /// Highest own and lateral orders in the list.
    extra_orders: (u8, u8),
}

impl CompiledModel {
    /// Sorts the rows into the dense part and the list; coefficients in turns.
    pub fn new(model: &ErrorModel, pitch_m: f32) -> Self {
        let per_pitch = 1.0 / pitch_m;
        let mut compiled = Self::default();
        for (dense, constant) in compiled.dense.iter_mut().zip(model.constants_m) {
            dense.constant = constant * per_pitch;
        }
        for (term, rows) in model.terms.iter().zip(&model.coefficients) {
            let rows = rows.map(|row| row.map(|k| k * per_pitch));
            compiled.add(term, rows);
        }
        compiled
    }

    fn add(&mut self, term: &Term, rows: TermCoefficients) {
        let order = DENSE_ORDERS.iter().position(|&n| *term == Term::own(n));
        if let Some(order) = order {
            for (dense, row) in self.dense.iter_mut().zip(rows) {
                dense.own[order] = row;
            }
        } else if *term == Term::lateral(1) {
            self.lateral = true;
            for (dense, row) in self.dense.iter_mut().zip(rows) {
                dense.lateral = row;
            }
        } else {
            let (own, lateral) = &mut self.extra_orders;
            *own = (*own).max(term.own_order);
            *lateral = (*lateral).max(term.lateral_order.unsigned_abs());
            let _ = self.extra.push((*term, rows)); // as many places as the table has
        }
    }

    /// Whether there are rows beyond equations (3) and (9).
    #[inline(always)]
    pub fn has_extra(&self) -> bool {
        !self.extra.is_empty()
    }

    /// Adds the further rows to the segments' errors, turns. At most 24 rows.
    pub fn add_extra(&self, basis: &Basis, errors: &mut [f32; SEGMENTS]) {
        for (segment, error) in errors.iter_mut().enumerate() {
            let basis = basis.segment(segment, self.extra_orders.0, self.extra_orders.1);
            for (term, rows) in &self.extra {
                let [sine, cosine] = basis.term(term);
                let [a, b] = rows[segment & 3];
                *error += a * sine + b * cosine;
            }
        }
    }
}

impl DenseSegment {
    /// Equation (3), turns.
    #[inline(always)]
    pub fn own_error(&self, own: Unit) -> f32 {
        let orders = equation_3_orders(own);
        let mut sum = self.constant;
        for k in 0..4 {
            sum += self.own[k][0] * orders[k].sine;
            sum += self.own[k][1] * orders[k].cosine;
        }
        sum
    }

    /// The lateral terms of equation (9), turns.
    #[inline(always)]
    pub fn lateral_error(&self, lateral: Unit) -> f32 {
        self.lateral[0] * lateral.sine + self.lateral[1] * lateral.cosine
    }
}
