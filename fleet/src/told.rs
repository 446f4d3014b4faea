//! A number of the answer, and how well it is known.

use serde::Serialize;

/// A number that was fitted, and how well it is known: by all recordings, and by the best of them alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Told {
    /// Its value.
    pub value: f64,
    /// Predicted standard deviation, all recordings together.
    pub deviation: f64,
    /// The same by that recording alone which tells it best.
    pub alone: f64,
    /// Before any data.
    pub prior: f64,
}

/// Share of the deviation before the data from which on a number says nothing of its own. A prior: nine tenths of the deviation are four fifths of
/// the variance, so that more than that is what was known before.
const UNTOLD: f64 = 0.9;

impl Told {
    /// True if the data of all recordings say more than what was known before.
    #[must_use]
    pub fn is_told(&self) -> bool {
        self.deviation < UNTOLD * self.prior
    }

    /// The same of the best recording alone.
    #[must_use]
    pub fn is_told_alone(&self) -> bool {
        self.alone < UNTOLD * self.prior
    }
}
