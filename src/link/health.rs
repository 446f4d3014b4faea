//! What the board has found out about itself at its start and in service. [`crate::health`] judges it.

use crate::drivers::converter::ConverterError;
use serde::{Deserialize, Serialize};

/// What the board has found out about itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// The converters' self-test, at each start. A failure stays until a start at which it passes, also if good frames follow.
    pub converters: ConverterTest,
    /// Test of the memory through which calibrations go to flash and back, at each start.
    pub memory: MemoryTest,
    /// The chip's option register (FLASH_OPTR), if it has one.
    pub option_bytes: Option<u32>,
    /// Frequency of the chip's slow oscillator by its main clock, hertz, if it is measured: two clocks that check each other.
    pub slow_clock_hz: Option<u32>,
    /// Conversions that were started and that BUSY has not answered with a pulse, since start, if they are counted; negative: pulses that no
    /// conversion asked for.
    pub unanswered: Option<i32>,
    /// Starts in a row that a fault caused, without a minute of service between them.
    pub faults_in_a_row: u8,
    /// Whether the board has therefore left alone what is stored.
    pub safe_mode: bool,
}

/// How the converters' self-test went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ConverterTest {
    /// There was none.
    #[default]
    NotRun,
    /// All was as it should be.
    Passed,
    /// What was found wrong at the last attempt.
    Failed(ConverterFault),
}

/// What the converters' self-test has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum ConverterFault {
    /// A chip does not answer as it should.
    #[error("chip {0} does not answer as it should")]
    Chip(u8),
    /// A pin cannot be read or driven.
    #[error("a pin cannot be read or driven")]
    Pin,
    /// No conversion begins.
    #[error("BUSY did not rise after CONVST")]
    BusyNeverRose,
    /// No conversion ends.
    #[error("BUSY did not fall")]
    BusyStuck,
}

/// How the test of memory went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum MemoryTest {
    /// There was none.
    #[default]
    NotRun,
    /// Every bit kept what was written.
    Passed,
    /// The first word that did not.
    Failed {
        /// Its address.
        address: u32,
    },
}

impl From<ConverterError> for ConverterFault {
    fn from(error: ConverterError) -> Self {
        match error {
            ConverterError::Chip { index, .. } => Self::Chip(index),
            ConverterError::Pin(_) => Self::Pin,
            ConverterError::BusyNeverRose { .. } => Self::BusyNeverRose,
            ConverterError::BusyStuck { .. } => Self::BusyStuck,
        }
    }
}

impl From<Result<(), ConverterError>> for ConverterTest {
    fn from(result: Result<(), ConverterError>) -> Self {
        match result {
            Ok(()) => Self::Passed,
            Err(error) => Self::Failed(error.into()),
        }
    }
}
