//! The chip's peripherals as far as the firmware uses them, one a file, each with the rules that its use must keep.

pub mod adc;
pub mod capture;
pub mod clocks;
pub mod crc;
pub mod debug;
pub mod dma;
pub mod edges;
pub mod exti;
pub mod flash;
pub mod gpio;
pub mod pwr;
pub mod rcc;
pub mod spi;
pub mod syscfg;
pub mod timer;
mod unit;
pub mod usart;
pub mod watchdog;
pub mod window;

pub use unit::Unit;

use crate::registers::Register;
use crate::rule::{Findings, Rule};
use crate::time::{NEVER, Ticks};
use clocks::Clocks;

/// What a peripheral is told with every access and at every instant of its own.
pub struct Access<'a> {
    /// The instant.
    pub now: Ticks,
    /// The clocks as they are.
    pub clocks: Clocks,
    /// Where broken rules go.
    pub findings: &'a mut Findings,
}

impl Access<'_> {
    /// Notes a broken rule.
    pub fn broken(&mut self, rule: Rule, detail: impl Into<String>) {
        self.findings.add(rule, self.now, detail.into());
    }
}

/// A peripheral's registers and its behaviour in time.
pub trait Peripheral {
    /// A register as it reads, without the effects of a read.
    fn peek(&self, register: &Register) -> u32;

    /// A read by the processor.
    fn read(&mut self, register: &Register, _: &mut Access) -> u32 {
        self.peek(register)
    }

    /// A write by the processor.
    fn write(&mut self, register: &Register, value: u32, access: &mut Access);

    /// The next instant at which something happens by itself.
    fn next(&self) -> Ticks {
        NEVER
    }

    /// Does what is due.
    fn advance(&mut self, _: &mut Access) {}
}

/// Registers that keep what is written.
#[derive(Clone, Debug)]
pub struct Words(Vec<u32>);

impl Words {
    /// A block of 1 KiB, zeros but for these values after reset, by their offset in bytes.
    pub fn after_reset(values: &[(u32, u32)]) -> Self {
        let mut words = vec![0; 256];
        for (offset, value) in values {
            words[(offset / 4) as usize] = *value;
        }
        Self(words)
    }

    /// A register.
    pub fn get(&self, register: &Register) -> u32 {
        self.at(register.offset)
    }

    /// A register by its offset.
    pub fn at(&self, offset: u32) -> u32 {
        self.0[(offset / 4) as usize]
    }

    /// Keeps a value.
    pub fn set(&mut self, register: &Register, value: u32) {
        self.put(register.offset, value);
    }

    /// Keeps a value, by offset.
    pub fn put(&mut self, offset: u32, value: u32) {
        self.0[(offset / 4) as usize] = value;
    }
}
