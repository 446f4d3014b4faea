//! What a recording lets us compare: a segment with a reference, or four segments with each other.

use super::observe::Sample;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::SEGMENTS;
use recording::{Column, Recording};
use serde::Serialize;

/// One scalar constraint that calibrated outputs fulfil up to noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// g_p of equation (5): all four segments.
    Parity,
    /// One segment (0 to 3) against the reference along its axis.
    Segment(usize),
}

impl Serialize for Channel {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

impl Channel {
    /// The channels of a recording: g_p where there are four segments, else every segment that has a reference.
    pub fn of(recording: &Recording) -> Vec<Self> {
        let samples = &recording.samples;
        if (0..SEGMENTS).all(|segment| samples.has_segment(segment)) {
            return vec![Self::Parity];
        }
        let referenced = |segment: &usize| {
            samples.has_segment(*segment) && samples.has(Column::Reference(segment % 2))
        };
        (0..SEGMENTS)
            .filter(referenced)
            .map(Self::Segment)
            .collect()
    }

    /// `g_p` or `segment_1` to `segment_4`.
    pub fn name(self) -> String {
        match self {
            Self::Parity => "g_p".to_owned(),
            Self::Segment(segment) => format!("segment_{}", segment + 1),
        }
    }

    /// Sign with which each segment's error enters; zero for segments that do not.
    pub fn signs(self) -> [f64; SEGMENTS] {
        match self {
            Self::Parity => PARITY_SIGN.map(f64::from),
            Self::Segment(segment) => {
                std::array::from_fn(|other| if other == segment { 1.0 } else { 0.0 })
            }
        }
    }

    /// Outputs of the segments that enter, metres; 0 for those that do not.
    pub fn places(self, sample: &Sample) -> [f64; SEGMENTS] {
        let signs = self.signs();
        std::array::from_fn(|segment| {
            if signs[segment] == 0.0 {
                0.0
            } else {
                sample.unmodified_m[segment]
            }
        })
    }

    /// Whether the sample has all that this channel needs.
    pub fn measured(self, sample: &Sample) -> bool {
        match self {
            Self::Parity => sample.seen.iter().all(|seen| *seen),
            Self::Segment(segment) => sample.seen[segment] && sample.reference_m[segment].is_some(),
        }
    }

    /// The constraint with unmodified outputs: g_p tilde of equation (6), or output minus reference; metres.
    pub fn raw_m(self, sample: &Sample) -> f64 {
        let outputs = sample.unmodified_m;
        match self {
            Self::Parity => outputs
                .iter()
                .zip(PARITY_SIGN)
                .map(|(output, sign)| f64::from(sign) * output)
                .sum(),
            Self::Segment(segment) => {
                outputs[segment] - sample.reference_m[segment].unwrap_or(outputs[segment])
            }
        }
    }
}
