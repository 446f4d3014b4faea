//! TIM8 as the firmware uses it: it counts the edges of a line on its channel 3, by the exclusive or of its first three channels.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use stm32_metapac::timer::regs::{CcerAdv, CcmrInput2ch, Cr1Gp16, Cr2Adv, SmcrAdv};
use stm32_metapac::timer::vals::{CcmrInputCcs, Sms, Ti1s, Ts};

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const ARR: u32 = 0x2C;

/// The peripheral.
#[derive(Debug)]
pub struct Edges {
    words: Words,
    counter: u32,
}

impl Edges {
    /// After reset.
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(ARR, 0xFFFF)]),
            counter: 0,
        }
    }

    /// An edge of channel 3's line, whose pin is this timer's; those of channels 1 and 2 are low.
    pub fn edge(&mut self, rises: bool) {
        let smcr = SmcrAdv(self.words.at(SMCR));
        let clocked = smcr.sms() == Sms::EXT_CLOCK_MODE && smcr.ts() == Ts::TI1FP1;
        let joined = Cr2Adv(self.words.at(CR2)).ti1s() == Ti1s::XOR;
        let input = CcmrInput2ch(self.words.at(CCMR1)).ccs(0) == CcmrInputCcs::TI4;
        let counts_falls = CcerAdv(self.words.at(CCER)).ccp(0);
        let on = Cr1Gp16(self.words.at(CR1)).cen();
        if on && clocked && joined && input && rises != counts_falls {
            self.counter = (self.counter + 1) % (self.words.at(ARR) + 1);
        }
    }
}

impl Peripheral for Edges {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "cnt" => self.counter,
            _ => self.words.get(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr1" | "cr2" | "smcr" | "ccmr_input" | "ccmr_output" | "ccer" => {
                self.words.set(register, value);
            }
            other => {
                let detail = format!("TIM8.{other}({}) is written", register.index);
                access.broken(Rule::Unmodelled, detail);
            }
        }
    }
}
