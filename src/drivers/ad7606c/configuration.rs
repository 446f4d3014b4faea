//! A chip's configuration as a list of chip-select frames, so that whoever has little time exchanges one of them at a time.
//!
//! The identity is asked for first. Then every register is written and read back, the CRC before all others: from then on every byte in
//! either direction is covered. At last the chip returns to conversion data.

use super::register::{self, Register};
use super::{Ad7606c, CHANNELS, COMMAND_BYTES, ChipError, ChipSettings, Command, compare};
use embedded_hal::spi::SpiDevice;

/// Registers that are set: diagnosis, configuration, four of ranges, eight of offsets, oversampling.
const REGISTERS: usize = 15;
/// Frames that ask for the identity.
const FIRST: usize = 2;
/// Frames of a register: it is written, and read by a command and the reply to it.
const FRAMES: usize = 3;
/// Frames up to the last register; one more brings the chip back to conversion data.
const UP_TO_THE_LAST: usize = FIRST + FRAMES * REGISTERS;

/// The chip-select frames of a configuration and of the return to conversion data, in their order.
#[derive(Clone, Debug)]
pub struct Script {
    steps: [Step; UP_TO_THE_LAST + 1],
}

/// One chip-select frame, and what its reply must be.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// What is sent.
    pub command: Command,
    reply: Reply,
}

/// What comes back.
#[derive(Clone, Copy, Debug)]
enum Reply {
    /// Nothing that counts.
    Any,
    /// The identity of such a chip.
    Identity,
    /// What was written.
    Value(u8),
}

impl Script {
    /// For a chip that has been reset and is to be set so.
    pub const fn new(settings: &ChipSettings) -> Self {
        let mut steps = [LEAVE; UP_TO_THE_LAST + 1];
        let mut number = 0;
        while number < UP_TO_THE_LAST {
            steps[number] = match number.checked_sub(FIRST) {
                None => identity(number),
                Some(rest) => of_register(setting(settings, rest / FRAMES), rest),
            };
            number += 1;
        }
        Self { steps }
    }

    /// The frame with this number, from zero; none after the last one.
    #[inline(always)]
    pub fn step(&self, number: u8) -> Option<&Step> {
        self.steps.get(usize::from(number))
    }
}

/// Back to conversion data.
const LEAVE: Step = Step {
    command: Command::new(0, 0, true),
    reply: Reply::Any,
};

const fn identity(number: usize) -> Step {
    let is_reply = number + 1 == FIRST;
    Step {
        command: Command::new(register::READ | Register::Id.address(), 0, false),
        reply: if is_reply {
            Reply::Identity
        } else {
            Reply::Any
        },
    }
}

/// A frame of a register, the one with the number `rest` after those of the identity.
const fn of_register((register, value): (Register, u8), rest: usize) -> Step {
    // The first one switches the CRC on.
    let has_crc = rest > 0;
    let address = register.address();
    let (command, value, reply) = match rest % FRAMES {
        0 => (address, value, Reply::Any),
        1 => (register::READ | address, 0, Reply::Any),
        _ => (register::READ | address, 0, Reply::Value(value)),
    };
    let command = Command::new(command, value, has_crc);
    Step { command, reply }
}

/// A register to be set, and to what; the last one is the oversampling.
const fn setting(settings: &ChipSettings, index: usize) -> (Register, u8) {
    const CHECKS: u8 = register::ROM_CRC_ERR_EN | register::INT_CRC_ERR_EN;
    match index {
        0 => (Register::DigitalDiagnosticEnable, CHECKS),
        1 => (Register::Config, register::CONFIG_NORMAL_ONE_DOUT),
        2..=5 => {
            let both = settings.range.code() << 4 | settings.range.code();
            let pair = (index - 2) as u8;
            (Register::Range { pair }, both)
        }
        6..=13 => {
            let channel = index - 6;
            let offset = settings.offset_counts[channel % CHANNELS];
            let channel = channel as u8;
            (Register::Offset { channel }, (offset as u8) ^ 0x80)
        }
        _ => (Register::Oversampling, settings.oversampling.code()),
    }
}

impl Step {
    /// Whether anything counts of what comes back.
    #[inline(always)]
    pub const fn is_judged(&self) -> bool {
        !matches!(self.reply, Reply::Any)
    }

    /// Whether what came back is right: as long as the command, zeros after it.
    ///
    /// # Errors
    /// Every variant of [`ChipError`] but those of the bus and of conversion frames.
    pub fn judge(&self, reply: [u8; COMMAND_BYTES]) -> Result<(), ChipError> {
        match self.reply {
            Reply::Any => Ok(()),
            Reply::Identity => judge_identity(self.command.value(reply)?),
            Reply::Value(wrote) => {
                let read = self.command.value(reply)?;
                compare(self.command.register(), wrote, read)
            }
        }
    }
}

#[cold]
#[inline(never)]
fn judge_identity(identity: u8) -> Result<(), ChipError> {
    match identity {
        level @ (0x00 | 0xFF) => Err(ChipError::Absent { level }),
        id if register::DEVICES.contains(&(id >> 4)) => Ok(()),
        id => Err(ChipError::WrongId { id }),
    }
}

impl<S: SpiDevice> Ad7606c<S> {
    /// Checks the identity, turns the CRC on and sets everything, each register read back. The chip stays in register mode.
    ///
    /// # Errors
    /// Every variant of [`ChipError`] but those of conversion frames.
    pub fn configure(&mut self, script: &Script) -> Result<(), ChipError> {
        self.register_mode = true;
        for step in &script.steps[..UP_TO_THE_LAST] {
            let reply = self.exchange(&step.command)?;
            step.judge(reply)?;
            self.crc = step.command.has_crc;
        }
        Ok(())
    }
}

impl<S> Ad7606c<S> {
    /// Tells the driver that a whole [`Script`] has been exchanged with the chip: conversion data, with CRC.
    pub const fn after_script(&mut self) {
        self.register_mode = false;
        self.crc = true;
    }
}
