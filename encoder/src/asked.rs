//! What is asked, and why nothing can be learned.

/// What is asked beside the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Question {
    /// Signal periods of one turn of the shaft: single poles and eccentricity are then learned too. An index that comes twice tells them.
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
    /// The index never changes where the place does.
    #[error(
        "found an index without a rising edge, wanted one in each turn (--column index=COLUMN), or none"
    )]
    NoPass,
    /// The index came at another period.
    #[error(
        "found the index {off:+.2} periods from where it mostly is, at {at_s} s, wanted it once in each turn of {periods} periods: another --periods-per-turn, or no lost samples"
    )]
    OtherPeriod {
        /// Time of the row.
        at_s: f64,
        /// Distance from the median of all, periods.
        off: f64,
        /// Periods of a turn, as stated or between two passes.
        periods: u32,
    },
    /// No correction of the pair makes it round within its ranges.
    #[error("found sine and cosine on no ellipse: {0}; wanted one pair's two channels")]
    Pair(String),
}
