//! What stands still while a debugger halts the processor.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use stm32_metapac::dbgmcu::regs::Apb1lfzr;

const APB1LFZR: u32 = 0x08;

/// The peripheral.
#[derive(Debug)]
pub struct Dbgmcu {
    words: Words,
}

impl Dbgmcu {
    /// After power-on: device 0x469, revision X (RM0440, 47.6.1).
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(0, 0x2003_6469)]),
        }
    }

    /// Whether the watchdog stands still while the processor is halted.
    pub fn watchdog_frozen(&self) -> bool {
        Apb1lfzr(self.words.at(APB1LFZR)).iwdg()
    }

    /// Whether the window watchdog does.
    pub fn window_watchdog_frozen(&self) -> bool {
        Apb1lfzr(self.words.at(APB1LFZR)).wwdg()
    }
}

impl Peripheral for Dbgmcu {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "idcode" => access.broken(Rule::ReadOnly, "DBGMCU.idcode"),
            _ => self.words.set(register, value),
        }
    }
}
