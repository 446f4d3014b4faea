//! The table of terms of the error model: which functions of phases and angle there are.

use crate::equations::OWN_ORDERS;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most rows in a table. A bound on the work: a model with more is refused, and the interrupt's cycles are bounded so.
pub const MAX_TERMS: usize = 24;
/// Most columns of one segment, constants aside.
pub const MAX_COLUMNS: usize = 2 * MAX_TERMS;
/// Highest order of the own phase. Derived from a clip's orders: 4, 8, 12 and 16 (docs/effects.md).
pub const MAX_OWN_ORDER: u8 = 16;
/// Highest order of the lateral phase, either sign. A prior: higher ones fall as a coil some teeth wide averages them.
pub const MAX_LATERAL_ORDER: u8 = 4;
/// Highest power of the angle. A prior: over ±1.5° a coil's sinc is a parabola, and what is odd a cubic.
pub const MAX_THETA_POWER: u8 = 3;

/// What a term is multiplied with besides its angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Multiplier {
    /// One.
    #[default]
    None = 0,
    /// Own speed, m/s.
    Speed,
    /// Board temperature minus the calibration's, kelvin.
    Temperature,
    /// Direction of travel: -1, 0 before the first motion, 1.
    Direction,
}

/// One row: `multiplier * theta^p * (a sin(n phi + m lambda) + b cos(n phi + m lambda))`.
///
/// phi: the segment's own phase, lambda: its lateral phase (the argument in equation 9), theta: mean unmodified angle, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Term {
    /// n, 0 to 16.
    pub own_order: u8,
    /// m, -4 to 4; not negative if n is 0.
    pub lateral_order: i8,
    /// p, 0 to 3.
    pub theta_power: u8,
    /// The further factor.
    pub multiplier: Multiplier,
}

/// Why a row is not possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TermError {
    /// Own order too high.
    #[error("own order {0} is above {MAX_OWN_ORDER}")]
    OwnOrder(u8),
    /// Lateral order out of range.
    #[error("lateral order {0} is not within ±{MAX_LATERAL_ORDER}")]
    LateralOrder(i8),
    /// Power of the angle too high.
    #[error("power {0} of theta is above {MAX_THETA_POWER}")]
    ThetaPower(u8),
    /// Negative lateral order without own order: the same functions as the positive one.
    #[error("lateral order {0} without own order: write it positive")]
    Mirrored(i8),
    /// The constant, which the model keeps apart.
    #[error("a constant term: it is kept in constants_m")]
    Constant,
    /// More rows than a table holds.
    #[error("more than {MAX_TERMS} terms")]
    TooMany,
    /// The same row as an earlier one.
    #[error("the same as term {0}")]
    Duplicate(usize),
}

/// What multipliers are at the most in ordinary use: an angle of 10 mrad (the paper's largest is 8.7), 1 m/s, 100 K.
const ORDINARY_THETA_RAD: f32 = 0.01;
/// The same of the speed, m/s. A prior: a planar motor's is 1 to 2 m/s.
const ORDINARY_SPEED_M_S: f32 = 1.0;
/// The same of the temperature, K. A prior: nearly the industrial range from end to end, 125 K.
const ORDINARY_TEMPERATURE_K: f32 = 100.0;

impl Term {
    /// What the factor before sine and cosine is in ordinary use: a coefficient times this is a length of the error.
    pub fn ordinary_factor(&self) -> f32 {
        let multiplier = match self.multiplier {
            Multiplier::None | Multiplier::Direction => 1.0,
            Multiplier::Speed => ORDINARY_SPEED_M_S,
            Multiplier::Temperature => ORDINARY_TEMPERATURE_K,
        };
        (0..self.theta_power).fold(multiplier, |factor, _| factor * ORDINARY_THETA_RAD)
    }

    /// A harmonic of the own phase.
    pub const fn own(order: u8) -> Self {
        Self {
            own_order: order,
            lateral_order: 0,
            theta_power: 0,
            multiplier: Multiplier::None,
        }
    }

    /// A harmonic of the lateral phase.
    pub const fn lateral(order: i8) -> Self {
        Self {
            own_order: 0,
            lateral_order: order,
            theta_power: 0,
            multiplier: Multiplier::None,
        }
    }

    /// The same row times theta^power.
    pub const fn with_theta(self, power: u8) -> Self {
        Self {
            theta_power: power,
            ..self
        }
    }

    /// The same row times a further factor.
    pub const fn with(self, multiplier: Multiplier) -> Self {
        Self { multiplier, ..self }
    }

    /// Whether it depends on a phase; if not, only its cosine part exists.
    pub const fn periodic(&self) -> bool {
        self.own_order != 0 || self.lateral_order != 0
    }

    #[inline] // built with the image, for size
    fn validate(&self) -> Result<(), TermError> {
        if self.own_order > MAX_OWN_ORDER {
            return Err(TermError::OwnOrder(self.own_order));
        }
        if self.lateral_order.unsigned_abs() > MAX_LATERAL_ORDER {
            return Err(TermError::LateralOrder(self.lateral_order));
        }
        if self.theta_power > MAX_THETA_POWER {
            return Err(TermError::ThetaPower(self.theta_power));
        }
        if self.own_order == 0 && self.lateral_order < 0 {
            return Err(TermError::Mirrored(self.lateral_order));
        }
        if *self == Self::default() {
            return Err(TermError::Constant);
        }
        Ok(())
    }
}

/// Which of a term's two functions a column is; as a number, the index into its coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigonometric {
    /// `sin(n phi + m lambda)`.
    Sine = 0,
    /// `cos(n phi + m lambda)`.
    Cosine = 1,
}

/// One column of a segment's regressors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Row of the table.
    pub term: usize,
    /// Sine or cosine part.
    pub part: Trigonometric,
}

/// A bounded table of terms. Row order is column order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TermTable(Vec<Term, MAX_TERMS>);

impl TermTable {
    /// Equation (3): own orders 1, 2, 4, 6.
    pub fn equation_3() -> Self {
        Self(OWN_ORDERS.into_iter().map(Term::own).collect())
    }

    /// Equation (9): equation (3) and the first lateral order.
    pub fn equation_9() -> Self {
        let mut table = Self::equation_3();
        let _ = table.0.push(Term::lateral(1)); // 5 of 24
        table
    }

    /// A table of these rows.
    ///
    /// # Errors
    /// The first row that is not possible or has no room, with its index.
    pub fn new(terms: &[Term]) -> Result<Self, (usize, TermError)> {
        let table = Self(Vec::from_slice(terms).map_err(|_| (MAX_TERMS, TermError::TooMany))?);
        table.validate()?;
        Ok(table)
    }

    /// Adds a row.
    ///
    /// # Errors
    /// Gives the row back if the table is full.
    pub fn push(&mut self, term: Term) -> Result<(), Term> {
        self.0.push(term)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rows in order.
    pub fn iter(&self) -> core::slice::Iter<'_, Term> {
        self.0.iter()
    }

    /// The columns of one segment in order: sine and cosine of each periodic row, the cosine alone of the others.
    pub fn columns(&self) -> impl Iterator<Item = Column> + '_ {
        self.0.iter().enumerate().flat_map(|(term, row)| {
            let sine = row.periodic().then_some(Column {
                term,
                part: Trigonometric::Sine,
            });
            sine.into_iter().chain([Column {
                term,
                part: Trigonometric::Cosine,
            }])
        })
    }

    /// Number of columns of one segment.
    pub fn column_count(&self) -> usize {
        self.0
            .iter()
            .map(|row| 1 + usize::from(row.periodic()))
            .sum()
    }

    /// Checks every row.
    ///
    /// # Errors
    /// Index of the first row that is not possible, and why.
    #[inline] // built with the image, for size
    pub fn validate(&self) -> Result<(), (usize, TermError)> {
        for (index, row) in self.0.iter().enumerate() {
            row.validate().map_err(|error| (index, error))?;
            if let Some(first) = self.0.iter().take(index).position(|other| other == row) {
                return Err((index, TermError::Duplicate(first)));
            }
        }
        Ok(())
    }
}
