//! Brings converters back that stopped answering in service: a chip whose supply dipped has forgotten its settings.
//!
//! Done in the sampling interrupt, a piece at each instant, so that no instant is missed for it: one chip-select frame of 24 clocks at a
//! time, or the look at what a frame has brought; 174 instants in all (8.7 ms at 20 kHz). Until the first good frame every reading is
//! the error that began it.

use super::error::ConverterError;
use crate::drivers::ad7606c::ChipError;

/// Readings that fail one after the other before the chips are reset: 1 ms at 20 kHz. At one bit error in 300 a reading fails every
/// second time, and one in a million runs is so long.
pub(super) const FAILURES: u16 = 20;
/// Instants between reset and the first register access: 400 us at 100 kHz, more at lower rates.
const SETTLE: u16 = 40;
/// Instants between two attempts, 50 ms at 20 kHz.
const PAUSE: u16 = 1000;

/// What is done at the next instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// A reading; so many before it failed.
    Service { failures: u16 },
    /// RESET rises; at the next instant it falls.
    Reset { high: bool },
    /// Waits.
    Settle { left: u16 },
    /// One chip-select frame of a chip's script.
    Set { chip: u8, step: u8 },
    /// A look at the reply to it.
    Judge { chip: u8, step: u8 },
    /// Waits before the next attempt.
    Pause { left: u16 },
}

/// State of the pair in service.
#[derive(Clone, Copy, Debug)]
pub(super) struct Revival {
    pub stage: Stage,
    /// The last reading's error, while there is one.
    pub error: ConverterError,
}

impl Revival {
    /// All is well.
    pub const fn new() -> Self {
        let error = ConverterError::Chip {
            index: 0,
            error: ChipError::Silent,
        };
        Self {
            stage: Stage::Service { failures: 0 },
            error,
        }
    }

    /// Set-up failed: the chips are reset and set at the readings that come.
    pub const fn from_reset(error: ConverterError) -> Self {
        Self {
            stage: Stage::Reset { high: true },
            error,
        }
    }

    /// Whether readings are tried.
    pub const fn in_service(&self) -> bool {
        matches!(self.stage, Stage::Service { .. })
    }

    /// A reading in service that did not fail.
    #[inline(always)]
    pub const fn serve(&mut self) {
        self.stage = Stage::Service { failures: 0 };
    }

    /// A reading that failed.
    pub const fn failed(&mut self, error: ConverterError) {
        self.error = error;
        if let Stage::Service { failures } = self.stage {
            let failures = failures + 1;
            self.stage = if failures < FAILURES {
                Stage::Service { failures }
            } else {
                Stage::Reset { high: true }
            };
        }
    }

    /// A frame of a chip's script has been exchanged; if its reply counts, the next instant looks at that.
    #[inline(always)]
    pub const fn exchanged(&mut self, is_judged: bool) {
        if let Stage::Set { chip, step } = self.stage {
            self.stage = match is_judged {
                true => Stage::Judge { chip, step },
                false => Stage::Set {
                    chip,
                    step: step + 1,
                },
            };
        }
    }

    /// A chip's script is at its end.
    pub const fn set(&mut self, chip: u8) {
        self.stage = match chip {
            0 => Stage::Set { chip: 1, step: 0 },
            _ => Stage::Service { failures: 0 },
        };
    }

    /// A stage is done; an error begins anew after a pause.
    pub const fn moved(&mut self, result: Result<(), ConverterError>) {
        if let Err(error) = result {
            self.error = error;
            self.stage = Stage::Pause { left: PAUSE };
            return;
        }
        self.stage = match self.stage {
            Stage::Service { .. } => Stage::Service { failures: 0 },
            Stage::Reset { high: true } => Stage::Reset { high: false },
            Stage::Reset { high: false } => Stage::Settle { left: SETTLE },
            Stage::Settle { left: 0 } => Stage::Set { chip: 0, step: 0 },
            Stage::Settle { left } => Stage::Settle { left: left - 1 },
            Stage::Set { chip, step } | Stage::Judge { chip, step } => Stage::Set {
                chip,
                step: step + 1,
            },
            Stage::Pause { left: 0 } => Stage::Reset { high: true },
            Stage::Pause { left } => Stage::Pause { left: left - 1 },
        };
    }
}
