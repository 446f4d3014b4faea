//! Power control: the regulator's range and the supply detector.

use super::{Access, Peripheral, Words};
use crate::registers::{NOT_BOOSTED, Register};
use crate::rule::Rule;
use stm32_metapac::pwr::regs::{Cr1, Cr2, Sr2};
use stm32_metapac::pwr::vals::Vos;

/// Falling thresholds of the supply detector's levels 0 to 6, typical, volts (DS12288, embedded reset and power control).
const DETECTOR_V: [f64; 7] = [2.00, 2.20, 2.33, 2.47, 2.59, 2.75, 2.84];
/// Falling thresholds of the brown-out reset's levels 0 to 4, typical, volts (the same table).
const BROWN_OUT_V: [f64; 5] = [1.66, 2.00, 2.20, 2.51, 2.81];

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const CR5: u32 = 0x80;

/// The peripheral.
#[derive(Debug)]
pub struct Pwr {
    words: Words,
    /// Supply, volts.
    pub supply_v: f64,
}

impl Pwr {
    /// After reset: range 1, not boosted (RM0440, 6.4).
    pub fn after_reset(supply_v: f64) -> Self {
        Self {
            words: Words::after_reset(&[(CR1, 0x0200), (0x08, 0x8000), (CR5, 0x0100)]),
            supply_v,
        }
    }

    /// Fastest clock of the processor in the chosen range, and cycles of it that one wait state more allows (RM0440, 3.3.3), hertz.
    pub fn limits_hz(&self) -> (u32, u32) {
        let boosted = self.words.at(CR5) & NOT_BOOSTED == 0;
        match Cr1(self.words.at(CR1)).vos() {
            Vos::RANGE1 if boosted => (170_000_000, 34_000_000),
            Vos::RANGE1 => (150_000_000, 30_000_000),
            _ => (26_000_000, 12_000_000),
        }
    }

    /// Whether the detector's threshold lies above the brown-out reset's, whose level the option bytes give.
    pub fn check_warning(&self, brown_out_level: u8, access: &mut Access) {
        let cr2 = Cr2(self.words.at(CR2));
        let warn = DETECTOR_V.get(usize::from(cr2.pls()));
        let reset = BROWN_OUT_V.get(usize::from(brown_out_level));
        if let (true, Some(warn), Some(reset)) = (cr2.pvde(), warn, reset)
            && warn <= reset
        {
            let detail = format!(
                "PWR.cr2: level {} warns at {warn} V, the brown-out reset of level {brown_out_level} comes at {reset} V",
                cr2.pls()
            );
            access.broken(Rule::SupplyWarning, detail);
        }
    }
}

impl Peripheral for Pwr {
    fn peek(&self, register: &Register) -> u32 {
        if register.name != "sr2" {
            return self.words.get(register);
        }
        let cr2 = Cr2(self.words.at(CR2));
        let threshold = DETECTOR_V.get(usize::from(cr2.pls())).unwrap_or(&0.0);
        let mut sr2 = Sr2(0);
        sr2.set_pvdo(cr2.pvde() && self.supply_v < *threshold);
        sr2.0
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr1" | "cr2" | "cr3" | "cr4" | "cr5" => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("PWR.{other} is written")),
        }
    }
}
