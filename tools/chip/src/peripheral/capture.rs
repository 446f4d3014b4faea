//! TIM16 as the firmware uses it: it counts its own clock, and edges of the slow oscillator capture the count.
//!
//! Captures come every 1, 2, 4 or 8 edges (IC1PSC), the first so many after the channel is switched on; CC1IF goes when the capture is read
//! (RM0440, general-purpose timers).

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks};
use stm32_metapac::timer::regs::{Ccer1chCmp, CcmrInput1ch, Cr11ch, Sr1chCmp, Tisel1ch};
use stm32_metapac::timer::vals::CcmrInputCcs;

/// TI1SEL's choice of the slow oscillator.
const SLOW_OSCILLATOR: u8 = 6;

const CR1: u32 = 0x00;
const SR: u32 = 0x10;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const ARR: u32 = 0x2C;
const CCR1: u32 = 0x34;
const TISEL: u32 = 0x5C;

/// The peripheral.
#[derive(Debug)]
pub struct Capture {
    words: Words,
    /// Whether the slow oscillator runs: the watchdog starts it.
    pub oscillates: bool,
    /// Period of the slow oscillator, ticks.
    pub period: Ticks,
    zero_at: Ticks,
    count: Ticks,
    due: Ticks,
}

impl Capture {
    /// After reset; the slow oscillator's period is that of the watchdog's clock.
    pub fn after_reset(period: Ticks) -> Self {
        Self {
            words: Words::after_reset(&[(ARR, 0xFFFF)]),
            oscillates: false,
            period,
            zero_at: 0,
            count: 1,
            due: NEVER,
        }
    }

    fn counts(&self) -> bool {
        Cr11ch(self.words.at(CR1)).cen()
    }

    fn captures(&self) -> bool {
        let input = CcmrInput1ch(self.words.at(CCMR1)).ccs(0) == CcmrInputCcs::TI4;
        let chosen = Tisel1ch(self.words.at(TISEL)).tisel(0) == SLOW_OSCILLATOR;
        let on = Ccer1chCmp(self.words.at(CCER)).cce(0);
        self.counts() && input && chosen && on && self.oscillates
    }

    /// Ticks from one capture to the next.
    fn interval(&self) -> Ticks {
        self.period << CcmrInput1ch(self.words.at(CCMR1)).icpsc(0)
    }

    fn reschedule(&mut self, now: Ticks) {
        self.due = match self.captures() {
            true => (now / self.period) * self.period + self.interval(),
            false => NEVER,
        };
    }
}

impl Peripheral for Capture {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn read(&mut self, register: &Register, access: &mut Access) -> u32 {
        match register.name {
            "cnt" if self.counts() => ((access.now - self.zero_at) / self.count) as u32 & 0xFFFF,
            "ccr" | "ccr_dither" => {
                let mut flags = Sr1chCmp(self.words.at(SR));
                flags.set_ccif(0, false);
                self.words.put(SR, flags.0);
                self.peek(register)
            }
            _ => self.peek(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match (register.name, register.index) {
            ("cr1", _) => {
                let before = self.counts();
                self.words.set(register, value);
                if self.counts() && !before {
                    self.count = access.clocks.timer1_cycle();
                    self.zero_at = access.now;
                }
            }
            ("ccmr_input" | "ccmr_output", 0) | ("ccer" | "tisel", _) => {
                self.words.set(register, value);
            }
            // A flag goes by writing a zero.
            ("sr", _) => {
                let flags = self.words.at(SR) & value;
                self.words.put(SR, flags);
            }
            (other, index) => {
                let detail = format!("TIM16.{other}({index}) is written");
                access.broken(Rule::Unmodelled, detail);
            }
        }
        self.reschedule(access.now);
    }

    fn next(&self) -> Ticks {
        self.due
    }

    fn advance(&mut self, access: &mut Access) {
        while access.now >= self.due {
            let count = (self.due - self.zero_at) / self.count;
            self.words.put(CCR1, count as u32 & 0xFFFF);
            let mut flags = Sr1chCmp(self.words.at(SR));
            flags.set_ccif(0, true);
            self.words.put(SR, flags.0);
            self.due += self.interval();
        }
    }
}
