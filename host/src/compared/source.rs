//! An estimate with what its file says of where it comes from.

use comparison::estimate::Estimate;

/// A calibration, a model or a recording.
#[derive(Clone, Debug)]
pub struct Compared {
    /// As an estimate.
    pub estimate: Estimate,
    /// The board's number, or the device that a recording names; none where that is not said.
    pub device: Option<Device>,
    /// Span and lateral offset of the segments, metres, where they are stated.
    pub stated: [Option<f64>; 2],
}

/// Whose readings they were.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Device {
    /// A board's own number.
    Board(String),
    /// Free text of a recording.
    Recording(String),
}
