//! System configuration: which port an interrupt line listens to, and whether the banks of the flash have changed places.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use stm32_metapac::syscfg::regs::Memrmp;

const MEMRMP: u32 = 0x00;
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

    /// Whether bank 2 lies where bank 1 is after a reset (RM0440, 10.2.1).
    pub fn banks_swapped(&self) -> bool {
        Memrmp(self.words.at(MEMRMP)).fb_mode()
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
            "memrmp" if Memrmp(value).mem_mode() == 0 => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("SYSCFG.{other} is written")),
        }
    }
}
