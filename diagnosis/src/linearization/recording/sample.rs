//! One sample of an amplitude, as shapes over place and time need it.

/// Orders of the phase from zero on, and columns of their sines and cosines. A definition: 0 to 8, of which equation (3) has four
/// and a third harmonic of the signals makes order 4 and its square 8.
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

#[cfg(test)]
impl Sample {
    /// At a place and a phase, rad, of no amplitude.
    pub(super) fn at(place_m: [f64; 2], phase_rad: f64) -> Self {
        Self {
            place_m,
            theta_rad: 0.0,
            progress: 0.0,
            phase: super::covariates::multiples(phase_rad),
            value: 0.0,
            fold: 0,
        }
    }
}
