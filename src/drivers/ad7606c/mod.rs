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

mod configuration;
mod error;
mod frame;
mod register;

pub use configuration::{Script, Step};
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

/// A chip-select frame of register access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    bytes: [u8; COMMAND_BYTES],
    has_crc: bool,
}

/// Bytes of the longest: command, value and CRC.
pub const COMMAND_BYTES: usize = 3;

impl Command {
    const fn new(command: u8, value: u8, has_crc: bool) -> Self {
        Self {
            bytes: [command, value, CRC8.checksum(&[command, value])],
            has_crc,
        }
    }

    /// What goes over the wire, and is as long as the reply.
    #[inline(always)]
    pub fn bytes(&self) -> &[u8] {
        if self.has_crc {
            &self.bytes
        } else {
            &self.bytes[..COMMAND_BYTES - 1]
        }
    }

    /// Address of its register.
    const fn register(&self) -> u8 {
        self.bytes[0] & !register::READ
    }

    /// The register's value by what came back for it.
    ///
    /// # Errors
    /// It fails its CRC.
    fn value(&self, reply: [u8; COMMAND_BYTES]) -> Result<u8, ChipError> {
        let [first, value, crc] = reply;
        if self.has_crc && CRC8.checksum(&[first, value]) != crc {
            return Err(ChipError::RegisterCrc {
                register: self.register(),
            });
        }
        Ok(value)
    }
}

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
            self.exchange(&self.command(0, 0))?;
            self.register_mode = false;
        }
        Ok(())
    }

    /// Reads one register by command and reply, two chip-select frames.
    ///
    /// # Errors
    /// Bus, or a reply that fails its CRC.
    pub fn read_register(&mut self, register: Register) -> Result<u8, ChipError> {
        let command = self.command(register::READ | register.address(), 0);
        self.exchange(&command)?;
        self.register_mode = true;
        let reply = self.exchange(&command)?;
        command.value(reply)
    }

    /// Writes one register, without reading it back.
    ///
    /// # Errors
    /// Bus, or a reply that fails its CRC on the way into register mode.
    pub fn write_register(&mut self, register: Register, value: u8) -> Result<(), ChipError> {
        if !self.register_mode {
            self.read_register(register)?;
        }
        self.exchange(&self.command(register.address(), value))
            .map(|_| ())
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

    fn write_verified(&mut self, register: Register, value: u8) -> Result<(), ChipError> {
        self.write_register(register, value)?;
        let read = self.read_register(register)?;
        compare(register.address(), value, read)
    }

    /// One chip-select frame of register access; returns what came back.
    ///
    /// # Errors
    /// Bus.
    pub fn exchange(&mut self, command: &Command) -> Result<[u8; COMMAND_BYTES], ChipError> {
        let mut bytes = command.bytes;
        self.spi
            .transfer_in_place(&mut bytes[..command.bytes().len()])
            .map_err(|error| ChipError::Bus(error.kind()))?;
        Ok(bytes)
    }
}

impl<S> Ad7606c<S> {
    fn command(&self, command: u8, value: u8) -> Command {
        Command::new(command, value, self.crc)
    }
}

const fn compare(register: u8, wrote: u8, read: u8) -> Result<(), ChipError> {
    if read == wrote {
        Ok(())
    } else {
        Err(ChipError::ReadBack {
            register,
            wrote,
            read,
        })
    }
}
