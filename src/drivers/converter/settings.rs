//! How the pair of converters is run.

use crate::drivers::ad7606c::{CHANNELS, ChipSettings, Oversampling, Range, Script};

/// Offset put on chip 1's grounded channel 8.
pub const WITNESS_COUNTS: i8 = 64;

/// How the pair is run.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// What sets each chip, as [`scripts`] makes it.
    pub scripts: &'static [Script; 2],
    /// Conversions averaged in the chip; [`Oversampling::X8`] takes 10 of the 50 us at 20 kHz.
    pub oversampling: Oversampling,
    /// Readings of BUSY after which [`Converter::convert`](super::Converter::convert) gives up; at 50 ns each 2048 are 100 us, enough up to [`Oversampling::X64`].
    pub busy_polls: u32,
}

impl Settings {
    /// The sensor board's: ±5 V, no oversampling (a moving courier is not averaged over its own motion).
    pub const BOARD: Self = Self {
        scripts: &BOARD_SCRIPTS,
        oversampling: BOARD_OVERSAMPLING,
        busy_polls: 2048,
    };
}

const BOARD_OVERSAMPLING: Oversampling = Oversampling::X1;
static BOARD_SCRIPTS: [Script; 2] = scripts(Range::Bipolar5V, BOARD_OVERSAMPLING);

/// What sets chip 0 and chip 1 to this range of all channels and this oversampling.
pub const fn scripts(range: Range, oversampling: Oversampling) -> [Script; 2] {
    let plain = ChipSettings {
        range,
        oversampling,
        offset_counts: [0; CHANNELS],
    };
    let mut witness = plain;
    witness.offset_counts[CHANNELS - 1] = WITNESS_COUNTS;
    [Script::new(&plain), Script::new(&witness)]
}
