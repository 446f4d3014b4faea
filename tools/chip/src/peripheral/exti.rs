//! Interrupt lines of the pins: edges become pending interrupts.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;

const IMR1: u32 = 0x00;
const RTSR1: u32 = 0x08;
const FTSR1: u32 = 0x0C;
const PR1: u32 = 0x14;

/// The peripheral.
#[derive(Debug)]
pub struct Exti {
    words: Words,
}

impl Exti {
    /// After reset (RM0440, 16.5).
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(IMR1, 0xFF82_0000), (0x20, 0xFFFF_FFFC)]),
        }
    }

    /// A pin's line has gone up or down.
    pub fn edge(&mut self, line: u32, rising: bool) {
        let chosen = if rising { RTSR1 } else { FTSR1 };
        if self.words.at(chosen) >> line & 1 == 1 {
            let pending = self.words.at(PR1) | 1 << line;
            self.words.put(PR1, pending);
        }
    }

    /// Lines 0 to 15 that interrupt, a bit each.
    pub fn pending(&self) -> u32 {
        self.words.at(PR1) & self.words.at(IMR1) & 0xFFFF
    }
}

impl Peripheral for Exti {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match (register.name, register.index) {
            ("imr" | "emr" | "rtsr" | "ftsr", _) => self.words.set(register, value),
            ("swier", 0) => {
                let pending = self.words.at(PR1) | value & self.words.at(IMR1);
                self.words.put(PR1, pending);
            }
            // A flag goes by writing a one.
            ("pr", 0) => {
                let pending = self.words.at(PR1) & !value;
                self.words.put(PR1, pending);
            }
            (other, index) => {
                access.broken(
                    Rule::Unmodelled,
                    format!("EXTI.{other}({index}) is written"),
                );
            }
        }
    }
}
