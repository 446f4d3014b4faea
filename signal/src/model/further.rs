//! What the interrupt adds to equation (3): the lateral terms of equation (9), and further rows, of all four segments at once.
//!
//! A row is `f (a sin(n phi + m lambda) + b cos(n phi + m lambda))`, f its factor. By the theorems of addition that is
//! `f (sin(n phi) A + cos(n phi) B)` with `A = a cos(m lambda) - b sin(m lambda)` and `B = a sin(m lambda) + b cos(m lambda)`: the same
//! operations for every row, whatever its orders, and no branch. A row is read once for all segments, not once for each.

use super::basis::Unit;
use super::terms::{MAX_LATERAL_ORDER, MAX_THETA_POWER};
use super::{MAX_TERMS, Term, TermCoefficients};
use crate::frame::SEGMENTS;
use crate::lanes::Lanes;
use core::array::from_fn;
use heapless::Vec;

/// [`Further::errors`] has so many multiples of the lateral phase.
const _: () = assert!(MAX_LATERAL_ORDER == 4);
/// And so many powers of the angle.
const _: () = assert!(MAX_THETA_POWER == 3);
/// Segments 1 and 3, 2 and 4. A definition: each of two directions has two segments.
const PAIRS: usize = 2;

/// Sines and cosines of an angle of each segment, pair by pair.
#[derive(Clone, Copy)]
struct Units {
    sine: [Lanes; PAIRS],
    cosine: [Lanes; PAIRS],
}

impl Units {
    /// The angle zero.
    const ZERO: Self = Self {
        sine: [Lanes([0.0; 2]); PAIRS],
        cosine: [Lanes([1.0; 2]); PAIRS],
    };

    #[inline(always)]
    fn new(units: &[Unit; SEGMENTS]) -> Self {
        Self {
            sine: from_fn(|p| Lanes([units[p].sine, units[p + 2].sine])),
            cosine: from_fn(|p| Lanes([units[p].cosine, units[p + 2].cosine])),
        }
    }

    /// Sums of the angles.
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        Self {
            sine: from_fn(|p| a.sine[p] * b.cosine[p] + a.cosine[p] * b.sine[p]),
            cosine: from_fn(|p| a.cosine[p] * b.cosine[p] - a.sine[p] * b.sine[p]),
        }
    }
}

/// What the terms beyond equation (3) depend on.
#[derive(Clone, Copy)]
pub(crate) struct Phases {
    /// Own phases.
    pub own: [Unit; SEGMENTS],
    /// Lateral phases.
    pub lateral: [Unit; SEGMENTS],
    /// Mean unmodified angle, radians.
    pub theta_rad: f32,
}

/// What rows can be multiplied with, by [`Multiplier`](super::Multiplier), of the segments of x and of y.
pub(crate) type Multipliers = [[f32; PAIRS]; 4];

/// One further row.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    /// Of sine and cosine, turns.
    sine: [Lanes; PAIRS],
    cosine: [Lanes; PAIRS],
    /// Sign of the lateral order.
    sign: f32,
    own_order: u8,
    /// Without its sign.
    lateral_order: u8,
    theta_power: u8,
    multiplier: u8,
}

impl Row {
    fn new(term: Term, rows: &TermCoefficients) -> Self {
        let part = |part: usize| from_fn(|p| Lanes([rows[p][part], rows[p + 2][part]]));
        Self {
            sine: part(0),
            cosine: part(1),
            sign: if term.lateral_order < 0 { -1.0 } else { 1.0 },
            own_order: term.own_order,
            lateral_order: term.lateral_order.unsigned_abs(),
            theta_power: term.theta_power,
            multiplier: term.multiplier as u8,
        }
    }
}

/// The terms beyond equation (3) as the interrupt applies them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Further {
    /// Whether equation (9) is in use.
    pub has_lateral: bool,
    /// Its coefficients, `[sine, cosine]`, turns.
    pub lateral: TermCoefficients,
    /// By own order, so that one multiple of the own phase after the other is made and none is kept.
    rows: Vec<Row, MAX_TERMS>,
}

impl Further {
    /// No terms.
    pub const NONE: Self = Self {
        has_lateral: false,
        lateral: [[0.0; 2]; SEGMENTS],
        rows: Vec::new(),
    };

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.has_lateral = false;
        self.lateral = [[0.0; 2]; SEGMENTS];
        self.rows.clear();
    }

    /// Adds a row that is not of equation (3); coefficients in turns.
    #[inline] // built with the image, for size
    pub fn add(&mut self, term: Term, rows: TermCoefficients) {
        if term == Term::lateral(1) {
            self.has_lateral = true;
            self.lateral = rows;
            return;
        }
        let after = |row: &Row| row.own_order > term.own_order;
        let place = self.rows.iter().position(after);
        let place = place.unwrap_or(self.rows.len());
        let _ = self.rows.push(Row::new(term, &rows)); // as many places as the table has
        // One swap after the other: the copy of rows over one another would be the image's only one, and takes 1.6 KB of flash.
        for behind in (place + 1..self.rows.len()).rev() {
            self.rows.swap(behind - 1, behind);
        }
    }

    /// Whether there are rows beyond equations (3) and (9).
    #[inline(always)]
    pub fn has_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// The further rows' part of the segments' errors, turns, pair by pair. At most 24 rows. Cost: [`super::cost`].
    #[inline(never)]
    pub fn errors(&self, phases: &Phases, multipliers: &Multipliers) -> [Lanes; PAIRS] {
        let (own, one) = (Units::new(&phases.own), Units::new(&phases.lateral));
        let two = one.plus(&one);
        let three = two.plus(&one);
        let lateral = [Units::ZERO, one, two, three, three.plus(&one)];
        let theta = phases.theta_rad;
        let powers = [1.0, theta, theta * theta, theta * theta * theta];
        let mut errors = [Lanes([0.0; 2]); PAIRS];
        let (mut along, mut order) = (Units::ZERO, 0);
        for row in &self.rows {
            for _ in order..row.own_order {
                along = along.plus(&own);
            }
            order = row.own_order;
            let across = &lateral[usize::from(row.lateral_order).min(lateral.len() - 1)];
            let power = powers[usize::from(row.theta_power & 3)];
            let multiplier = &multipliers[usize::from(row.multiplier & 3)];
            for p in 0..PAIRS {
                let (a, b) = (row.sine[p], row.cosine[p]);
                let (sine, cosine) = (across.sine[p] * row.sign, across.cosine[p]);
                let of_sine = a * cosine - b * sine;
                let of_cosine = a * sine + b * cosine;
                let sum = along.sine[p] * of_sine + along.cosine[p] * of_cosine;
                errors[p] = errors[p] + sum * (multiplier[p] * power);
            }
        }
        errors
    }
}
