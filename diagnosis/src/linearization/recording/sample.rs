//! One sample of an amplitude, as shapes over place and time need it.

/// Orders of the phase from zero on, and columns of their sines and cosines.
pub(super) const PHASE_ORDERS: usize = 9;

/// One sample of a segment's amplitude.
pub(super) struct Sample {
    pub(super) place_m: [f64; 2],
    pub(super) theta_rad: f64,
    pub(super) progress: f64,
    /// Sine and cosine of the phase and its multiples.
    pub(super) phase: [(f64, f64); PHASE_ORDERS],
    pub(super) value: f64,
    pub(super) fold: usize,
}
