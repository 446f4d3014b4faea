//! Why a session does not start, and the check of a number that it is told.

/// Why a session does not start.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A number is outside its range, or not one.
    #[error("{name} is {value}, wanted {low} to {high}")]
    Range {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f32,
        /// Smallest.
        low: f32,
        /// Largest.
        high: f32,
    },
    /// The model has no term that the parity can give, or more than six.
    #[error("the model must have 1 to 6 terms of the own phase alone")]
    Terms,
    /// A session is under way.
    #[error("a session is under way")]
    Busy,
}

/// Not a number fails as well.
#[inline(never)]
pub(super) fn within(
    name: &'static str,
    value: f32,
    low: f32,
    high: f32,
) -> Result<(), StartError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(StartError::Range {
            name,
            value,
            low,
            high,
        })
    }
}
