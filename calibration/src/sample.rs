//! One pose's averaged outputs.

use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::model::Observation;

/// Words of a sample in memory. A definition: what `Sample::to_words` writes.
pub(super) const SAMPLE_WORDS: usize = 10;

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

    /// As plain words, for memory that holds many: [`Sample::from_words`].
    pub(super) fn to_words(self) -> [u32; SAMPLE_WORDS] {
        let [a, b, c, d] = self.unmodified.map(|p| p.teeth.cast_unsigned());
        let [e, f, g, h] = self.unmodified.map(|p| p.fraction_turns.to_bits());
        let direction = u32::from_le_bytes(self.direction.map(i8::cast_unsigned));
        let temperature = self.temperature_delta_k.to_bits();
        [a, b, c, d, e, f, g, h, direction, temperature]
    }

    /// The sample of these words.
    pub(super) fn from_words(words: &[u32; SAMPLE_WORDS]) -> Self {
        let [a, b, c, d, e, f, g, h, direction, temperature] = *words;
        let pairs = [(a, e), (b, f), (c, g), (d, h)];
        Self {
            unmodified: pairs.map(|(teeth, fraction)| Coordinate {
                teeth: teeth.cast_signed(),
                fraction_turns: f32::from_bits(fraction),
            }),
            direction: direction.to_le_bytes().map(u8::cast_signed),
            temperature_delta_k: f32::from_bits(temperature),
        }
    }

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
