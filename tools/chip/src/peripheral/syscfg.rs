//! System configuration: which port an interrupt line listens to.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;

const EXTICR: u32 = 0x08;

/// The peripheral.
#[derive(Debug)]
pub struct Syscfg {
    words: Words,
}

impl Syscfg {
    /// After reset (RM0440, 10.2).
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(0x04, 0x7C00_0001)]),
        }
    }

    /// The port (0 is A) that an interrupt line listens to.
    pub fn port(&self, line: u32) -> usize {
        let word = self.words.at(EXTICR + line / 4 * 4);
        (word >> (line % 4 * 4) & 0xF) as usize
    }
}

impl Peripheral for Syscfg {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "exticr" => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("SYSCFG.{other} is written")),
        }
    }
}
