//! One pose's averaged outputs.

use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::model::Observation;

/// Sign of each segment in the parity, equation (5).
pub const PARITY_SIGN: [f32; SEGMENTS] = [1.0, -1.0, -1.0, 1.0];

/// What a standing courier's frames say, averaged: all that any row needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Unmodified outputs.
    pub unmodified: [Coordinate; SEGMENTS],
    /// Last direction of travel, -1, 0 or 1.
    pub direction: [i8; SEGMENTS],
    /// Temperature over the reference, kelvin.
    pub temperature_delta_k: f32,
}

impl Sample {
    /// Nothing.
    pub const ZERO: Self = Self {
        unmodified: [Coordinate {
            teeth: 0,
            fraction_turns: 0.0,
        }; SEGMENTS],
        direction: [0; SEGMENTS],
        temperature_delta_k: 0.0,
    };

    /// Of one frame.
    #[must_use]
    pub fn of(frame: &Frame) -> Self {
        Self {
            unmodified: frame.segments.map(|s| s.unmodified),
            direction: [0, 1, 0, 1].map(|axis: usize| frame.direction[axis] as i8),
            temperature_delta_k: frame.raw.temperature_delta_k,
        }
    }

    /// Unmodified parity, equation (6), metres.
    #[must_use]
    pub fn parity_m(&self, pitch_m: f32) -> f32 {
        let [p1, p2, p3, p4] = self.unmodified;
        (p1.minus_turns(p3) - p2.minus_turns(p4)) * pitch_m
    }

    /// As the error model wants it; the courier stands.
    #[must_use]
    pub fn observation(&self) -> Observation {
        Observation {
            unmodified: self.unmodified,
            speed_m_s: [0.0; SEGMENTS],
            direction: self.direction.map(f32::from),
            temperature_delta_k: self.temperature_delta_k,
        }
    }
}
