//! The window watchdog: it counts down with the bus clock, interrupts a step before it would reset, and is put back by a write (RM0440, 43).

use super::{Access, Peripheral};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, TICK_HZ, Ticks};
use stm32_metapac::wwdg::regs::{Cfr, Cr};

/// Clocks of the bus in a step at the smallest prescaler (RM0440, 43.3.4).
const STEP_CLOCKS: u64 = 4096;
/// Counts below this are a reset; this one is the early interrupt.
const LAST: u8 = 0x40;

/// The peripheral.
#[derive(Debug)]
pub struct Wwdg {
    configuration: Cfr,
    /// Count at the last write, and when that was.
    count: u8,
    since: Ticks,
    step: Ticks,
    runs: bool,
    early: bool,
    expired: bool,
    due: Ticks,
}

impl Wwdg {
    /// After reset: count and window are at their greatest.
    pub fn after_reset() -> Self {
        Self {
            configuration: Cfr(0x7F),
            count: 0x7F,
            since: 0,
            step: NEVER,
            runs: false,
            early: false,
            expired: false,
            due: NEVER,
        }
    }

    /// Whether it wants a reset.
    pub fn expired(&self) -> bool {
        self.expired
    }

    /// Whether its interrupt line is up.
    pub fn interrupts(&self) -> bool {
        self.early && self.configuration.ewi()
    }

    /// It stood still for so long.
    pub fn stood_still(&mut self, duration: Ticks) {
        self.since += duration;
        self.reschedule();
    }

    fn reschedule(&mut self) {
        let steps_to = |count: u8| u64::from(self.count.saturating_sub(count));
        let left = if self.early { LAST - 1 } else { LAST };
        self.due = match self.runs {
            true => self.since + steps_to(left) * self.step,
            false => NEVER,
        };
    }

    fn write_count(&mut self, value: Cr, access: &mut Access) {
        let (prescaler, hz) = (self.configuration.0 >> 11 & 0b111, access.clocks.pclk1_hz);
        self.step = (STEP_CLOCKS << prescaler) * TICK_HZ / u64::from(hz);
        (self.count, self.since) = (value.t(), access.now);
        // Once on it stays on.
        self.runs |= value.wdga();
        if self.runs && self.count < LAST {
            access.broken(Rule::Watchdog, "WWDG.cr: a count below the last one");
        }
        self.early = false;
        self.reschedule();
    }
}

impl Peripheral for Wwdg {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "cr" => u32::from(self.count) | u32::from(self.runs) << 7,
            "cfr" => self.configuration.0,
            _ => u32::from(self.early),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr" => self.write_count(Cr(value), access),
            "cfr" if Cfr(value).w() != 0x7F => {
                access.broken(Rule::Unmodelled, "WWDG.cfr: a window");
            }
            "cfr" => self.configuration = Cfr(value),
            _ => self.early &= value & 1 == 1,
        }
    }

    fn next(&self) -> Ticks {
        self.due
    }

    fn advance(&mut self, access: &mut Access) {
        if access.now < self.due {
            return;
        }
        match self.early {
            false => {
                self.early = true;
                self.reschedule();
            }
            true => {
                self.expired = true;
                self.due = NEVER;
                access.broken(Rule::Watchdog, "the window watchdog was not put back");
            }
        }
    }
}
