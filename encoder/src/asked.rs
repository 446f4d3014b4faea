//! What is asked, and why nothing can be learned.

/// What is asked beside the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Question {
    /// Signal periods of one turn of the shaft: single poles and eccentricity are then learned too.
    pub periods_per_turn: Option<u32>,
}

/// Why nothing can be learned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Too little motion.
    #[error(
        "found {found} stretches of {periods} periods that go one way without a break, wanted {wanted} or more: a longer motion"
    )]
    Motion {
        /// Stretches found.
        found: usize,
        /// Periods of each.
        periods: f64,
        /// Stretches wanted.
        wanted: usize,
    },
    /// The circle is not gone through.
    #[error(
        "found sine and cosine on no whole circle, wanted a motion over several periods of one pair's signals"
    )]
    Circle,
    /// No correction of the pair makes it round within its ranges.
    #[error("found sine and cosine on no ellipse: {0}; wanted one pair's two channels")]
    Pair(String),
}
