//! Which coefficients the parity alone can give, and the row of equation (7) for them.
//!
//! Fitted: terms of the own phase only, and the one identifiable sum of the constants. Held at the values in force: terms
//! of the lateral phase, which the parity cannot tell from the other pair's own (docs/notes/joint.md), and those of speed,
//! temperature or direction, which a standing courier does not excite.

use super::joint::MAX_FITTED;
use super::sample::Sample;
use crate::equations::PARITY_SIGN;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::model::{Basis, ErrorModel, MAX_LATERAL_ORDER, MAX_OWN_ORDER, Multiplier, Term};

/// Most unknowns: six terms of two coefficients for four segments, and the offset.
pub const PLATEN_UNKNOWNS: usize = SEGMENTS * 2 * MAX_FITTED + 1;

/// Regression of the parity on the coefficients of some terms of a model.
#[derive(Clone, Debug)]
pub struct Regression {
    geometry: Geometry,
    /// The model in force without what is fitted.
    held: ErrorModel,
    fitted: heapless::Vec<u8, MAX_FITTED>,
}

impl Regression {
    /// Fits what can be fitted of `model`'s terms; `None` if these are more than six, or none.
    #[must_use]
    pub fn new(geometry: &Geometry, model: &ErrorModel) -> Option<Self> {
        let mut new = Self {
            geometry: *geometry,
            held: model.clone(),
            fitted: heapless::Vec::new(),
        };
        new.held.constants_m = [0.0; SEGMENTS];
        let rows = &mut new.held.coefficients;
        for (index, (term, rows)) in model.terms.iter().zip(rows).enumerate() {
            if of_own_phase(term) {
                new.fitted.push(index as u8).ok()?;
                *rows = [[0.0; 2]; SEGMENTS];
            }
        }
        (!new.fitted.is_empty()).then_some(new)
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        SEGMENTS * self.columns() + 1
    }

    /// Unknowns of one segment, its constant aside; segment `i`'s are `i * columns()..`.
    #[must_use]
    pub fn columns(&self) -> usize {
        2 * self.fitted.len()
    }

    /// Nominal geometry.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Equation (7): row and right-hand side in metres, so that `row * unknowns = rhs` where the parity vanishes.
    /// The row is as long as there are unknowns, the rest zero.
    #[must_use]
    pub fn row(&self, sample: &Sample) -> ([f32; PLATEN_UNKNOWNS], f32) {
        let basis = Basis::new(&self.geometry, &sample.observation());
        let mut row = [0.0; PLATEN_UNKNOWNS];
        let mut parity_m = sample.parity_m(self.geometry.pitch_m);
        for segment in 0..SEGMENTS {
            let sign = PARITY_SIGN[segment];
            let functions = basis.segment(segment, MAX_OWN_ORDER, MAX_LATERAL_ORDER);
            let columns = &mut row[segment * self.columns()..][..self.columns()];
            for (pair, &term) in columns.as_chunks_mut::<2>().0.iter_mut().zip(&self.fitted) {
                let term = self
                    .held
                    .terms
                    .iter()
                    .nth(term.into())
                    .copied()
                    .unwrap_or_default();
                *pair = functions.term(&term).map(|f| f * sign);
            }
            parity_m += sign * self.held.error_m(&basis, segment);
        }
        row[self.unknowns() - 1] = 1.0;
        (row, -parity_m)
    }

    /// Corrections e of all segments at a sample, metres, without their constants; `unknowns` as [`Regression::row`] has them, none for zeros.
    #[must_use]
    pub fn corrections_m(&self, unknowns: &[f32], sample: &Sample) -> [f32; SEGMENTS] {
        let basis = Basis::new(&self.geometry, &sample.observation());
        let row = self.row(sample).0;
        core::array::from_fn(|segment| {
            let first = segment * self.columns();
            let columns = row.iter().zip(unknowns).skip(first).take(self.columns());
            let fitted: f32 = columns.map(|(function, k)| function * k).sum();
            PARITY_SIGN[segment] * fitted + self.held.error_m(&basis, segment)
        })
    }

    /// One segment's correction without its constant as a functional of the unknowns, at a phase in turns.
    #[must_use]
    pub fn correction(&self, segment: usize, phase_turns: f32) -> [f32; PLATEN_UNKNOWNS] {
        let mut sample = Sample::ZERO;
        sample
            .unmodified
            .iter_mut()
            .for_each(|p| p.fraction_turns = phase_turns);
        let mut functional = self.row(&sample).0;
        for (column, value) in functional[..self.unknowns()].iter_mut().enumerate() {
            let own = column / self.columns() == segment;
            *value = if own {
                *value * PARITY_SIGN[segment]
            } else {
                0.0
            };
        }
        functional
    }

    /// The model with the unknowns put in; the offsets' sum is spread equally over the constants (the gauge).
    #[must_use]
    pub fn model(&self, unknowns: &[f32]) -> ErrorModel {
        let mut model = self.held.clone();
        for segment in 0..SEGMENTS {
            let values = unknowns.iter().skip(segment * self.columns());
            for (&term, i) in self.fitted.iter().zip(0..) {
                let mut pair = values.clone().skip(2 * i);
                if let (Some(rows), Some(a), Some(b)) = (
                    model.coefficients.get_mut(usize::from(term)),
                    pair.next(),
                    pair.next(),
                ) {
                    rows[segment] = [*a, *b];
                }
            }
            let offset = unknowns.get(self.unknowns() - 1).copied().unwrap_or(0.0);
            model.constants_m[segment] = PARITY_SIGN[segment] * offset / SEGMENTS as f32;
        }
        model
    }
}

fn of_own_phase(term: &Term) -> bool {
    term.own_order != 0
        && term.lateral_order == 0
        && term.theta_power == 0
        && term.multiplier == Multiplier::None
}
