//! Register map of the AD7606C-16, as far as the driver uses it (data sheet, Register Summary).

use crc::{Algorithm, Crc};

/// CRC of a register access: x^8 + x^2 + x + 1 from zero over command and value.
// With a table: registers are set in the sampling interrupt too, when the chips come back in service.
pub static CRC8: Crc<u8> = Crc::<u8>::new(&Algorithm {
    width: 8,
    poly: 0x07,
    init: 0,
    refin: false,
    refout: false,
    xorout: 0,
    check: 0xF4,
    residue: 0,
});

/// Read flag in the command byte.
pub(super) const READ: u8 = 1 << 6;
/// Device field of the identity register: 3 in the data sheet and in no-OS; users of evaluation boards read 0x22
/// (EngineerZone, question 575145), so that 2 counts as the same part. The AD7606B answers 1.
pub(super) const DEVICES: [u8; 2] = [0x3, 0x2];
/// Normal operation, all channels on DOUTA, internal oversampling clock, no status header.
pub(super) const CONFIG_NORMAL_ONE_DOUT: u8 = 0x00;
/// Check of the chip's own configuration memory, on after reset.
pub(super) const ROM_CRC_ERR_EN: u8 = 1 << 0;
/// CRC on every access and every conversion frame.
pub(super) const INT_CRC_ERR_EN: u8 = 1 << 2;

/// A register and its number within its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Register {
    /// Error summary and reset detection.
    Status,
    /// Operation mode, data lines, status header.
    Config,
    /// Ranges of channels `2 pair` (lower four bits) and `2 pair + 1`; pair 0 to 3.
    Range {
        /// 0 to 3.
        pair: u8,
    },
    /// Oversampling ratio.
    Oversampling,
    /// Offset added to a channel, 0x80 for none.
    Offset {
        /// 0 to 7.
        channel: u8,
    },
    /// Which digital checks run.
    DigitalDiagnosticEnable,
    /// Which of them failed.
    DigitalDiagnosticError,
    /// Device and silicon revision.
    Id,
}

impl Register {
    /// Address on the wire, 6 bits.
    pub const fn address(self) -> u8 {
        match self {
            Self::Status => 0x01,
            Self::Config => 0x02,
            Self::Range { pair } => 0x03 + (pair & 0x3),
            Self::Oversampling => 0x08,
            Self::Offset { channel } => 0x11 + (channel & 0x7),
            Self::DigitalDiagnosticEnable => 0x21,
            Self::DigitalDiagnosticError => 0x22,
            Self::Id => 0x2F,
        }
    }
}

/// Input ranges used here: single-ended, bipolar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// -2.5 V to 2.5 V.
    Bipolar2V5,
    /// -5 V to 5 V.
    Bipolar5V,
    /// -6.25 V to 6.25 V.
    Bipolar6V25,
    /// -10 V to 10 V, the one after reset.
    Bipolar10V,
    /// -12.5 V to 12.5 V.
    Bipolar12V5,
}

impl Range {
    /// Field value, 4 bits.
    pub const fn code(self) -> u8 {
        match self {
            Self::Bipolar2V5 => 0,
            Self::Bipolar5V => 1,
            Self::Bipolar6V25 => 2,
            Self::Bipolar10V => 3,
            Self::Bipolar12V5 => 4,
        }
    }

    /// Voltage at 32768 counts.
    pub const fn full_scale_v(self) -> f32 {
        match self {
            Self::Bipolar2V5 => 2.5,
            Self::Bipolar5V => 5.0,
            Self::Bipolar6V25 => 6.25,
            Self::Bipolar10V => 10.0,
            Self::Bipolar12V5 => 12.5,
        }
    }
}

/// Conversions averaged in the chip for one result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Oversampling {
    X1,
    X2,
    X4,
    X8,
    X16,
    X32,
    X64,
    X128,
    X256,
}

impl Oversampling {
    /// Field value, 4 bits: the ratio's logarithm to base 2.
    pub const fn code(self) -> u8 {
        self as u8
    }
}
