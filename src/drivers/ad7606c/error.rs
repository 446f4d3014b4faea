//! What one chip can answer wrongly.

use embedded_hal::spi::ErrorKind;

/// What one chip can answer wrongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChipError {
    /// The bus itself failed.
    Bus(ErrorKind),
    /// Nobody answers: the data line stays at one level.
    Absent {
        /// What was read in place of the identity, all zeros or all ones.
        level: u8,
    },
    /// Another chip answers.
    WrongId {
        /// Identity register: device in the upper four bits, silicon revision in the lower.
        id: u8,
    },
    /// A register does not hold what was written to it.
    ReadBack {
        /// Which one.
        register: u8,
        /// Written.
        wrote: u8,
        /// Found.
        read: u8,
    },
    /// A register's reply fails its CRC.
    RegisterCrc {
        /// Which one.
        register: u8,
    },
    /// A conversion frame fails its CRC.
    FrameCrc {
        /// As received.
        received: u16,
        /// Computed over the eight words received.
        computed: u16,
    },
    /// A conversion frame of zeros only, CRC included. The CRC of zeros is zero, so only this tells a dead data line.
    Silent,
}

impl core::fmt::Display for ChipError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Self::Bus(kind) => write!(f, "SPI transfer failed: {kind}"),
            Self::Absent { level } => write!(f, "no answer: the identity reads {level:#04x}"),
            Self::WrongId { id } => write!(
                f,
                "identity {id:#04x} is not an AD7606C-16's (0x3_ or 0x2_)"
            ),
            Self::ReadBack {
                register,
                wrote,
                read,
            } => {
                write!(
                    f,
                    "register {register:#04x} holds {read:#04x}, wanted {wrote:#04x}"
                )
            }
            Self::RegisterCrc { register } => {
                write!(f, "register {register:#04x}: reply fails its CRC")
            }
            Self::FrameCrc { received, computed } => {
                write!(
                    f,
                    "conversion frame: CRC {received:#06x}, wanted {computed:#06x}"
                )
            }
            Self::Silent => write!(f, "conversion frame of zeros only: dead data line"),
        }
    }
}

impl core::error::Error for ChipError {}
