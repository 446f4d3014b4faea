//! A segment whose readings come late.

/// How late, and what it reads then.
#[derive(Clone, Debug, PartialEq)]
pub struct LateSegment {
    /// How late, s.
    pub delay_s: f64,
    /// What the reading of a delay later is above each sample's, m; not finite where no reading tells it.
    pub ahead_m: Vec<f64>,
}
