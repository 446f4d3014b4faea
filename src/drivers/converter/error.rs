//! What can go wrong with the pair of converters.

use crate::drivers::ad7606c::ChipError;
use crate::frame::Status;
use embedded_hal::digital;

/// What can go wrong with the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ConverterError {
    /// One of the chips.
    Chip {
        /// 0 or 1.
        index: u8,
        /// What it did.
        error: ChipError,
    },
    /// A pin could not be read or set.
    Pin(digital::ErrorKind),
    /// BUSY did not rise after CONVST: no conversion runs, or the line is broken.
    BusyNeverRose {
        /// Times it was read.
        polls: u32,
    },
    /// BUSY did not fall.
    BusyStuck {
        /// Times it was read.
        polls: u32,
    },
}

impl core::fmt::Display for ConverterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Self::Chip { index, error } => write!(f, "converter {index}: {error}"),
            Self::Pin(kind) => write!(f, "converter pin: {kind}"),
            Self::BusyNeverRose { polls } => {
                write!(f, "converter busy did not rise within {polls} readings")
            }
            Self::BusyStuck { polls } => {
                write!(f, "converter busy did not fall within {polls} readings")
            }
        }
    }
}

impl core::error::Error for ConverterError {}

impl ConverterError {
    /// The status bit that tells of it in a frame.
    pub const fn status(&self) -> Status {
        match self {
            Self::Chip { .. } => Status::CONVERTER_CRC,
            _ => Status::CONVERTER_TIMEOUT,
        }
    }
}
