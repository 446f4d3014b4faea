//! A general-purpose timer as the firmware uses two: one counts up and makes a pulse on channel 1, the other counts its updates.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks};
use stm32_metapac::timer::regs::{CcerGp16, CcmrOutput2ch, Cr1Core, Cr2Gp16, SmcrGp16};
use stm32_metapac::timer::vals::{Mms, Ocm, Sms, Ts};

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const CCR1: u32 = 0x34;

/// The peripheral.
#[derive(Debug)]
pub struct Timer {
    name: &'static str,
    words: Words,
    counter: u32,
    /// Where the counter was zero, if it counts its own clock.
    zero_at: Option<Ticks>,
    /// Ticks of a count.
    count: Ticks,
    updates: u32,
}

impl Timer {
    /// After reset; `width` is the counter's, bits.
    pub fn after_reset(name: &'static str, width: u32) -> Self {
        Self {
            name,
            words: Words::after_reset(&[(ARR, u32::MAX >> (32 - width))]),
            counter: 0,
            zero_at: None,
            count: 1,
            updates: 0,
        }
    }

    /// Updates since the last call, each one a trigger for other timers if it is chosen as such.
    pub fn take_triggers(&mut self) -> u32 {
        let updates = std::mem::take(&mut self.updates);
        match Cr2Gp16(self.words.at(CR2)).mms() {
            Mms::UPDATE => updates,
            _ => 0,
        }
    }

    /// Triggers of the timer behind internal trigger 2: counted in external clock mode 1.
    pub fn count_triggers(&mut self, triggers: u32) {
        let smcr = SmcrGp16(self.words.at(SMCR));
        let listens = smcr.sms() == Sms::EXT_CLOCK_MODE && smcr.ts() == Ts::ITR2;
        if listens && self.enabled() {
            let limit = u64::from(self.words.at(ARR)) + 1;
            self.counter = ((u64::from(self.counter) + u64::from(triggers)) % limit) as u32;
        }
    }

    /// Level of channel 1; none if it drives nothing.
    pub fn channel1(&self, now: Ticks) -> Option<bool> {
        if !CcerGp16(self.words.at(CCER)).cce(0) {
            return None;
        }
        match CcmrOutput2ch(self.words.at(CCMR1)).ocm(0) {
            Ocm::PWM_MODE1 => Some(self.value(now) < self.words.at(CCR1)),
            _ => Some(false),
        }
    }

    fn enabled(&self) -> bool {
        Cr1Core(self.words.at(CR1)).cen()
    }

    fn value(&self, now: Ticks) -> u32 {
        match self.zero_at {
            Some(zero) => ((now - zero) / self.count) as u32,
            None => self.counter,
        }
    }

    fn period(&self) -> Ticks {
        (u64::from(self.words.at(ARR)) + 1) * self.count
    }

    fn write_cr1(&mut self, value: u32, access: &mut Access) {
        let internal = SmcrGp16(self.words.at(SMCR)).sms() != Sms::EXT_CLOCK_MODE;
        let (before, now) = (self.enabled(), Cr1Core(value).cen());
        if internal && now && !before {
            self.count = (u64::from(self.words.at(PSC)) + 1) * access.clocks.timer1_cycle();
            self.zero_at = Some(access.now - u64::from(self.counter) * self.count);
        }
        if before && !now {
            self.counter = self.value(access.now);
            self.zero_at = None;
        }
        self.words.put(CR1, value);
    }
}

impl Peripheral for Timer {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn read(&mut self, register: &Register, access: &mut Access) -> u32 {
        match register.name {
            "cnt" => self.value(access.now),
            _ => self.peek(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match (register.name, register.index) {
            ("cr1", _) => self.write_cr1(value, access),
            ("cr2" | "smcr" | "psc" | "arr" | "arr_dither" | "ccer", _) => {
                self.words.set(register, value);
            }
            ("ccr" | "ccr_dither", 0) | ("ccmr_input" | "ccmr_output", _) => {
                self.words.set(register, value);
            }
            // UG: the counter begins anew.
            ("egr", _) => {
                if value & 1 == 1 {
                    self.counter = 0;
                    self.zero_at = self.zero_at.map(|_| access.now);
                }
            }
            ("cnt", _) if self.zero_at.is_none() => self.counter = value,
            (other, index) => {
                let detail = format!("{}.{other}({index}) is written", self.name);
                access.broken(Rule::Unmodelled, detail);
            }
        }
    }

    fn next(&self) -> Ticks {
        let Some(zero) = self.zero_at else {
            return NEVER;
        };
        zero + self.period()
    }

    fn advance(&mut self, access: &mut Access) {
        while let Some(zero) = self.zero_at
            && access.now >= zero + self.period()
        {
            self.zero_at = Some(zero + self.period());
            self.updates += 1;
        }
    }
}

impl Timer {
    /// The next instant at which channel 1 changes, after `now`.
    pub fn next_edge(&self, now: Ticks) -> Ticks {
        let (Some(zero), Some(_)) = (self.zero_at, self.channel1(now)) else {
            return NEVER;
        };
        let falls = zero + u64::from(self.words.at(CCR1)) * self.count;
        if now < falls {
            falls
        } else {
            zero + self.period()
        }
    }
}
