//! How the pair of converters is run.

use crate::drivers::ad7606c::{CHANNELS, ChipSettings, Oversampling, Range};

/// Offset put on chip 1's grounded channel 8.
pub const WITNESS_COUNTS: i8 = 64;

/// How the pair is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Input range of all channels.
    pub range: Range,
    /// Conversions averaged in the chip; [`Oversampling::X8`] takes 10 of the 50 us at 20 kHz.
    pub oversampling: Oversampling,
    /// Readings of BUSY after which [`Converter::convert`](super::Converter::convert) gives up; at 50 ns each 2048 are 100 us, enough up to [`Oversampling::X64`].
    pub busy_polls: u32,
}

impl Settings {
    /// The sensor board's: ±5 V, no oversampling (a moving courier is not averaged over its own motion).
    pub const BOARD: Self = Self {
        range: Range::Bipolar5V,
        oversampling: Oversampling::X1,
        busy_polls: 2048,
    };
}

/// What a chip is set to in service.
pub(super) const fn chip_settings(settings: &Settings, chip: u8) -> ChipSettings {
    let mut offset_counts = [0; CHANNELS];
    if chip == 1 {
        offset_counts[CHANNELS - 1] = WITNESS_COUNTS;
    }
    ChipSettings {
        range: settings.range,
        oversampling: settings.oversampling,
        offset_counts,
    }
}
