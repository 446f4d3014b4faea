//! What a finding is about: a command refuses what it computes with, and only tells of the rest.

use crate::Finding;
use crate::finding::Kind;

/// A part of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Outputs of the segments: their wires, tooth counts, unit and pitch.
    Segments,
    /// Distance of a pair's segments: the scale of the angle.
    Span,
    /// The independent reference.
    Reference,
    /// Commanded poses.
    Commands,
    /// The coordination sensor: its electrodes, height, full scale and lever arms.
    Coordination,
}

impl Kind {
    /// What a finding of this kind is about.
    #[must_use]
    pub fn subject(self) -> Subject {
        match self {
            Self::SegmentsExchanged
            | Self::SegmentReversed
            | Self::Quadrature
            | Self::Pitch
            | Self::PositionUnit => Subject::Segments,
            Self::Span => Subject::Span,
            Self::ReferenceAxes
            | Self::ReferenceSign
            | Self::ReferenceUnit
            | Self::ReferenceIsReading => Subject::Reference,
            Self::Commanded => Subject::Commands,
            Self::Electrodes | Self::DiodeAxes | Self::HeightOrFullScale | Self::Lever => {
                Subject::Coordination
            }
        }
    }
}

impl Finding {
    /// True if it, or what explains the readings as well, is about one of these.
    #[must_use]
    pub fn is_about(&self, subjects: &[Subject]) -> bool {
        let one = |finding: &Self| subjects.contains(&finding.kind.subject());
        one(self) || self.or.iter().flatten().any(one)
    }
}
