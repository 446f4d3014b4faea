//! A candidate: what it would change, and why it is believed.

use crate::equations::OWN_ORDERS;
use crate::frame::SEGMENTS;
use crate::model::{ErrorModel, Term};
use crate::watch::Amounts;
use serde::{Deserialize, Serialize};

/// Smallest change of the position that is worth a write to flash: half of the sensor's resolution (paper, section 1), metres rms.
const LEAST_MOVE_M: f32 = 0.1e-6;

/// What a candidate would change, and how sure that is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// By how much it moves the position, metres rms over a tooth, along the axis that it moves more.
    pub moves_m: f32,
    /// Standard deviation of that, metres.
    pub deviation_m: f32,
    /// The position's gain in the mean of squares, deviations: it is believed from five on, or from 3.4 where these are drawn once.
    pub gain: f32,
    /// Evidence that it fits rows better that neither has seen, of what is wanted.
    pub evidence: f32,
    /// Segment of its largest wave, 0 to 3.
    pub segment: u8,
    /// Order of that wave.
    pub order: u8,
    /// Size of that wave, metres rms.
    pub size_m: f32,
    /// Windows of motion that it rests on.
    pub windows: u32,
}

impl Proposal {
    /// Nothing.
    pub const NONE: Self = Self {
        moves_m: 0.0,
        deviation_m: 0.0,
        gain: 0.0,
        evidence: 0.0,
        segment: 0,
        order: 0,
        size_m: 0.0,
        windows: 0,
    };

    /// Whether it is believed, and worth a write to flash. What its gain is not sure of is no part of a candidate.
    #[must_use]
    pub fn is_believed(&self) -> bool {
        self.evidence >= 1.0 && self.moves_m >= LEAST_MOVE_M
    }
}

/// Takes changes of equation (3)'s amounts, errors of the calibrated outputs, off a model's corrections; false, and nothing is
/// changed, if it lacks one of the terms.
#[must_use]
pub fn amend(model: &mut ErrorModel, changes_m: &Amounts) -> bool {
    let place = |order: u8| {
        model
            .terms
            .iter()
            .position(|term| *term == Term::own(order))
    };
    let [Some(a), Some(b), Some(c), Some(d)] = OWN_ORDERS.map(place) else {
        return false;
    };
    for (term, order) in [a, b, c, d].into_iter().zip(0..) {
        let Some(rows) = model.coefficients.get_mut(term) else {
            return false;
        };
        for (segment, row) in rows.iter_mut().enumerate() {
            let first = segment * (changes_m.len() / SEGMENTS) + 2 * order;
            let changes = changes_m.get(first..first + 2).unwrap_or(&[]);
            row.iter_mut().zip(changes).for_each(|(k, by)| *k -= by);
        }
    }
    true
}
