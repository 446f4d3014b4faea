//! One AD7606C-16 in software mode on an SPI bus, all channels on DOUTA, every read checked by its CRC.
//!
//! # Wire, mode CPOL = 1, CPHA = 0 (SPI mode 2), most significant bit first
//! ```text
//! register access  16 clocks, 24 with the CRC on; the reply to a read comes in the NEXT chip-select frame
//!   SDI    | 0 | R/W | A5..A0 | D7..D0 | CRC-8 |       R/W: 1 reads; writing address 0 returns to conversion data
//!   DOUTA  |   don't care     | D7..D0 | CRC-8 |
//! conversion data  8 x 16 clocks, 16 more with the CRC on
//!   DOUTA  | V1 | V2 | V3 | V4 | V5 | V6 | V7 | V8 | CRC-16 |   two's complement; SDI stays zero
//! ```
//! CRC-8: x^8 + x^2 + x + 1; CRC-16: 0x755B (x^16 + x^14 + x^13 + x^12 + x^10 + x^8 + x^6 + x^4 + x^3 + x + 1); both start at zero.
//! A read command takes the chip out of conversion data into register mode; writes are understood in register mode only.
//!
//! Sources: AD7606C-16 data sheet (Analog Devices, Rev. 0); Analog Devices' no-OS driver `drivers/adc/ad7606/ad7606.c` (commands,
//! both polynomials, reset and set-up times, conversion times) and Linux `drivers/iio/adc/ad7606_spi.c` (command word, delayed reply).

mod error;
mod frame;
mod register;

pub use error::ChipError;
pub use frame::{
    CHANNELS, CRC16, FRAME_BYTES, FrameBytes, check_frame, decode_frame, pairs, words,
};
pub use register::{CRC8, Oversampling, Range, Register};

use embedded_hal::spi::{Error as _, SpiDevice};

/// What a chip is set to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChipSettings {
    /// Input range of all eight channels.
    pub range: Range,
    /// Conversions averaged in the chip for one result.
    pub oversampling: Oversampling,
    /// Counts added by the chip to each channel's result, -128 to 127.
    pub offset_counts: [i8; CHANNELS],
}

/// Pieces of a configuration.
pub const CONFIGURE_STEPS: u8 = 15;

/// Driver of one chip. Keeps no copy of the registers but knows in which of its two modes the chip is.
#[derive(Debug)]
pub struct Ad7606c<S> {
    spi: S,
    register_mode: bool,
    crc: bool,
}

impl<S: SpiDevice> Ad7606c<S> {
    /// Takes the chip's SPI device; nothing is sent.
    pub const fn new(spi: S) -> Self {
        Self {
            spi,
            register_mode: false,
            crc: false,
        }
    }

    /// Tells the driver that the chip's reset line was pulsed: conversion data, no CRC.
    pub const fn after_reset(&mut self) {
        self.register_mode = false;
        self.crc = false;
    }

    /// Checks the identity, turns the CRC on and sets everything, each register read back.
    ///
    /// # Errors
    /// Every variant of [`ChipError`] but those of conversion frames.
    pub fn configure(&mut self, settings: &ChipSettings) -> Result<(), ChipError> {
        (0..CONFIGURE_STEPS).try_for_each(|step| self.configure_step(settings, step))
    }

    /// One of the [`CONFIGURE_STEPS`] pieces of [`Ad7606c::configure`], in order: at most five chip-select frames.
    ///
    /// # Errors
    /// As [`Ad7606c::configure`].
    pub fn configure_step(&mut self, settings: &ChipSettings, step: u8) -> Result<(), ChipError> {
        const CHECKS: u8 = register::ROM_CRC_ERR_EN | register::INT_CRC_ERR_EN;
        match step {
            0 => {
                self.identify()?;
                // First of all: from here on every byte in either direction is covered.
                self.write_register(Register::DigitalDiagnosticEnable, CHECKS)?;
                self.crc = true;
                self.verify(Register::DigitalDiagnosticEnable, CHECKS)
            }
            1 => self.write_verified(Register::Config, register::CONFIG_NORMAL_ONE_DOUT),
            2..=5 => {
                let both = settings.range.code() << 4 | settings.range.code();
                self.write_verified(Register::Range { pair: step - 2 }, both)
            }
            6..=13 => {
                let channel = step - 6;
                let offset = settings
                    .offset_counts
                    .get(usize::from(channel))
                    .copied()
                    .unwrap_or(0);
                self.write_verified(Register::Offset { channel }, (offset as u8) ^ 0x80)
            }
            _ => self.set_oversampling(settings.oversampling),
        }
    }

    /// Sets the oversampling ratio and reads it back; the chip stays in register mode.
    ///
    /// # Errors
    /// Bus, CRC or read-back.
    pub fn set_oversampling(&mut self, ratio: Oversampling) -> Result<(), ChipError> {
        self.write_verified(Register::Oversampling, ratio.code())
    }

    /// Returns from register mode to conversion data; nothing if it is there.
    ///
    /// # Errors
    /// Bus.
    pub fn leave_register_mode(&mut self) -> Result<(), ChipError> {
        if self.register_mode {
            self.command(0, 0)?;
            self.register_mode = false;
        }
        Ok(())
    }

    /// Reads one register by command and reply, two chip-select frames.
    ///
    /// # Errors
    /// Bus, or a reply that fails its CRC.
    pub fn read_register(&mut self, register: Register) -> Result<u8, ChipError> {
        let command = register::READ | register.address();
        self.command(command, 0)?;
        self.register_mode = true;
        let [first, value, crc] = self.command(command, 0)?;
        if self.crc && CRC8.checksum(&[first, value]) != crc {
            return Err(ChipError::RegisterCrc {
                register: register.address(),
            });
        }
        Ok(value)
    }

    /// Writes one register, without reading it back.
    ///
    /// # Errors
    /// Bus, or a reply that fails its CRC on the way into register mode.
    pub fn write_register(&mut self, register: Register, value: u8) -> Result<(), ChipError> {
        if !self.register_mode {
            self.read_register(register)?;
        }
        self.command(register.address(), value).map(|_| ())
    }

    /// Reads the eight channels of the last conversion: 144 clocks and 16 table look-ups. `counts` is untouched on error.
    ///
    /// # Errors
    /// Bus, CRC, or a dead data line.
    pub fn read_frame(&mut self, counts: &mut [i16; CHANNELS]) -> Result<(), ChipError> {
        let mut bytes = [0; FRAME_BYTES];
        self.spi
            .transfer_in_place(&mut bytes)
            .map_err(|error| ChipError::Bus(error.kind()))?;
        *counts = decode_frame(&bytes)?;
        Ok(())
    }

    fn identify(&mut self) -> Result<(), ChipError> {
        match self.read_register(Register::Id)? {
            level @ (0x00 | 0xFF) => Err(ChipError::Absent { level }),
            id if register::DEVICES.contains(&(id >> 4)) => Ok(()),
            id => Err(ChipError::WrongId { id }),
        }
    }

    fn write_verified(&mut self, register: Register, value: u8) -> Result<(), ChipError> {
        self.write_register(register, value)?;
        self.verify(register, value)
    }

    fn verify(&mut self, register: Register, wrote: u8) -> Result<(), ChipError> {
        let read = self.read_register(register)?;
        if read == wrote {
            Ok(())
        } else {
            Err(ChipError::ReadBack {
                register: register.address(),
                wrote,
                read,
            })
        }
    }

    /// One chip-select frame of register access; returns what came back.
    fn command(&mut self, command: u8, value: u8) -> Result<[u8; 3], ChipError> {
        let mut bytes = [command, value, CRC8.checksum(&[command, value])];
        let frame = if self.crc {
            &mut bytes[..]
        } else {
            &mut bytes[..2]
        };
        self.spi
            .transfer_in_place(frame)
            .map_err(|error| ChipError::Bus(error.kind()))?;
        Ok(bytes)
    }
}
