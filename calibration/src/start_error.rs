//! Why a session does not start.

use crate::range::OutOfRange;

/// Why a session does not start.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StartError {
    /// A number is outside its range, or not one.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// The model has no term that the parity can give, or more than six.
    #[error("the model must have 1 to 6 terms of the own phase alone")]
    Terms,
    /// A session is under way.
    #[error("a session is under way")]
    Busy,
}
