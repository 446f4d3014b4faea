//! The error model: what is added to a segment's unmodified output, equations (3) and (9) and further rows.
//!
//! SI side ([`ErrorModel`], stored and sent) and machine side (turns, in the interrupt). A further effect is a further
//! [`Term`] in the table; nothing else changes.

mod basis;
mod compiled;
mod cost;
mod further;
mod terms;

pub use basis::{Basis, Observation, SegmentBasis, Unit};
pub(crate) use basis::{lateral_units, mean_angle_turns};
pub(crate) use compiled::OwnPolynomial;
pub use cost::{BACKGROUND_CYCLES, most_further_rows, most_rows_beside_a_map};
pub(crate) use further::{Further, Phases};
pub use terms::{
    Column, MAX_COLUMNS, MAX_LATERAL_ORDER, MAX_OWN_ORDER, MAX_TERMS, MAX_THETA_POWER, Multiplier,
    Term, TermError, TermTable, Trigonometric,
};

use crate::frame::SEGMENTS;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Coefficients of one term, `[segment][sine, cosine]`: metres, per unit of the multiplier, per rad^p.
pub type TermCoefficients = [[f32; 2]; SEGMENTS];

/// Error model of all four segments, SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorModel {
    /// The constants k_i,0, metres. Only their parity sum is identifiable (docs/design.md, gauge).
    pub constants_m: [f32; SEGMENTS],
    /// Which terms there are.
    pub terms: TermTable,
    /// One entry per term, in the table's order.
    pub coefficients: Vec<TermCoefficients, MAX_TERMS>,
}

/// Why an error model cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A row of the table is not possible.
    #[error("term {index}: {error}")]
    Term {
        /// Row, from 0.
        index: usize,
        /// What is wrong with it.
        error: TermError,
    },
    /// Table and coefficients differ in length.
    #[error("{coefficients} coefficient rows for {terms} terms")]
    Length {
        /// Terms in the table.
        terms: usize,
        /// Rows of coefficients.
        coefficients: usize,
    },
    /// A coefficient is not finite or above its limit.
    #[error("segment {}: {}, found {value}, wanted -{limit} to {limit}", .segment + 1, Place(*.term))]
    Coefficient {
        /// Segment, 0 to 3.
        segment: usize,
        /// Row of the table; none for the constant.
        term: Option<usize>,
        /// The coefficient, in its unit.
        value: f32,
        /// Largest magnitude allowed.
        limit: f32,
    },
}

/// Where a coefficient stands, in words.
struct Place(Option<usize>);

impl core::fmt::Display for Place {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            Some(term) => write!(formatter, "coefficient of term {term}"),
            None => formatter.write_str("constant"),
        }
    }
}

/// Largest coefficient, in its own unit: far above any physical one, far below what could overflow. Derived from sums of 24 terms
/// with multipliers of a hundred: 1e7, where an f32 ends at 3e38.
const COEFFICIENT_LIMIT: f32 = 1.0e3;

impl ErrorModel {
    /// A model of these terms with all coefficients zero.
    pub fn zero(terms: TermTable) -> Self {
        let mut coefficients = Vec::new();
        for _ in terms.iter() {
            // The table's capacity is the same.
            let _ = coefficients.push([[0.0; 2]; SEGMENTS]);
        }
        Self {
            constants_m: [0.0; SEGMENTS],
            terms,
            coefficients,
        }
    }

    /// Checks that the interrupt can use the model.
    ///
    /// # Errors
    /// The first row or coefficient that it cannot.
    #[inline] // built with the image, for size
    pub fn validate(&self) -> Result<(), ModelError> {
        self.terms
            .validate()
            .map_err(|(index, error)| ModelError::Term { index, error })?;
        if self.terms.len() != self.coefficients.len() {
            return Err(ModelError::Length {
                terms: self.terms.len(),
                coefficients: self.coefficients.len(),
            });
        }
        for (segment, &value) in self.constants_m.iter().enumerate() {
            check(segment, None, value)?;
        }
        for (term, rows) in self.coefficients.iter().enumerate() {
            for (segment, row) in rows.iter().enumerate() {
                row.iter()
                    .try_for_each(|&value| check(segment, Some(term), value))?;
            }
        }
        Ok(())
    }

    /// Writes one segment's coefficients from values in the order of [`TermTable::columns`]; missing ones are left.
    pub fn set_columns(&mut self, segment: usize, values: &[f32]) {
        for (column, &value) in self.terms.columns().zip(values) {
            if let Some(slot) = self
                .coefficients
                .get_mut(column.term)
                .and_then(|rows| rows.get_mut(segment))
            {
                slot[column.part as usize] = value;
            }
        }
    }

    /// Reads one segment's coefficients in the order of [`TermTable::columns`] and returns how many were written.
    pub fn read_columns(&self, segment: usize, out: &mut [f32]) -> usize {
        let values = self.terms.columns().filter_map(|column| {
            Some(self.coefficients.get(column.term)?.get(segment)?[column.part as usize])
        });
        out.iter_mut()
            .zip(values)
            .map(|(slot, value)| *slot = value)
            .count()
    }

    /// Largest possible magnitude of one segment's error by the constant and the terms that depend on phases only, metres.
    #[inline] // built with the image, for size
    pub fn bound_m(&self, segment: usize) -> f32 {
        let constant = self.constants_m.get(segment).map_or(0.0, |k| k.abs());
        let rows = self.terms.iter().zip(&self.coefficients);
        rows.filter(|(term, _)| term.theta_power == 0 && term.multiplier == Multiplier::None)
            .filter_map(|(_, rows)| rows.get(segment))
            .fold(constant, |sum, [a, b]| sum + a.abs() + b.abs())
    }

    /// The error e of one segment by this model, metres, from a basis of the same geometry.
    pub fn error_m(&self, basis: &Basis, segment: usize) -> f32 {
        let mut sum = self.constants_m.get(segment).copied().unwrap_or(0.0);
        let basis = basis.segment(segment, MAX_OWN_ORDER, MAX_LATERAL_ORDER);
        for (term, rows) in self.terms.iter().zip(&self.coefficients) {
            let [sine, cosine] = basis.term(term);
            let [a, b] = rows.get(segment).copied().unwrap_or_default();
            sum += a * sine + b * cosine;
        }
        sum
    }
}

fn check(segment: usize, term: Option<usize>, value: f32) -> Result<(), ModelError> {
    if value.abs() <= COEFFICIENT_LIMIT {
        return Ok(());
    }
    Err(ModelError::Coefficient {
        segment,
        term,
        value,
        limit: COEFFICIENT_LIMIT,
    })
}
