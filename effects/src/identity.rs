//! What an amount is, for code that asks: the name of an amount is for readers.

use serde::{Deserialize, Serialize};

/// What an amount stands for, where code needs to know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Identity {
    /// A wave over a segment's tooth phases, times a factor.
    Wave(Wave),
    /// Growth of the ruling along x (0) or y (1) with temperature, 1/K.
    Growth {
        /// 0 along x, 1 along y.
        axis: usize,
    },
    /// What that growth makes of the ruling's scale at the mean temperature.
    GrowthAtMean {
        /// 0 along x, 1 along y.
        axis: usize,
    },
    /// What a segment brought along to a stretch from a way that is not recorded.
    BroughtAlong,
}

/// One part of a wave over the tooth phases of a segment: `factor * sin` or `factor * cos` of
/// `own_order * own phase + lateral_order * phase across`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// Order of the own tooth phase; 0 and a cosine is a constant.
    pub own_order: usize,
    /// Order of the tooth phase across the segment, signed.
    pub lateral_order: i32,
    /// Sine or cosine.
    pub part: Part,
    /// What it is multiplied by.
    pub factor: Factor,
}

impl Wave {
    /// A factor that is the same over the whole tooth.
    #[must_use]
    pub fn constant(segment: usize, factor: Factor) -> Self {
        Self {
            segment,
            own_order: 0,
            lateral_order: 0,
            part: Part::Cosine,
            factor,
        }
    }
}

/// Half of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// Its sine.
    Sine,
    /// Its cosine.
    Cosine,
}

impl Part {
    /// Both, in their order.
    pub const BOTH: [Self; 2] = [Self::Sine, Self::Cosine];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sine => "sine",
            Self::Cosine => "cosine",
        }
    }

    /// This part of a sine and a cosine.
    #[must_use]
    pub fn of(self, (sine, cosine): (f64, f64)) -> f64 {
        match self {
            Self::Sine => sine,
            Self::Cosine => cosine,
        }
    }
}

/// What a wave is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// Nothing.
    One,
    /// A power of the courier's angle, rad.
    Angle(i32),
    /// The segment's speed along its direction, m/s.
    Speed,
    /// The direction of travel, as it is or as it is remembered: -1 to 1.
    Way,
    /// The board's temperature less its mean, K.
    Warmth,
    /// The logarithm of the pair's amplitude, as far as the place explains it.
    Amplitude,
    /// A place on the platen.
    Place,
    /// A logged column.
    Logged,
    /// Anything else.
    Other,
}
