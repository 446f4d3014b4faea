//! The unit of check sums: a polynomial of its own, fed by words (RM0440, 16.3).

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use stm32_metapac::crc::regs::Cr;
use stm32_metapac::crc::vals::{RevIn, RevOut};

const CR: u32 = 0x08;
const INIT: u32 = 0x10;
const POL: u32 = 0x14;

/// The peripheral.
#[derive(Debug)]
pub struct Crc {
    words: Words,
    remainder: u32,
}

impl Crc {
    /// After reset (RM0440, 16.4): the polynomial of Ethernet, 32 bits.
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(INIT, u32::MAX), (POL, 0x04C1_1DB7)]),
            remainder: u32::MAX,
        }
    }

    fn width(&self) -> u32 {
        [32, 16, 8, 7][usize::from(Cr(self.words.at(CR)).polysize().to_bits())]
    }

    /// Takes in `bytes` bytes of a value, the most significant first.
    fn take(&mut self, value: u32, bytes: u32, access: &mut Access) {
        let value = match Cr(self.words.at(CR)).rev_in() {
            RevIn::NORMAL => value,
            RevIn::WORD if bytes == 4 => value.reverse_bits(),
            _ => {
                let detail = "CRC: the order of bits is turned round in parts of what is written";
                return access.broken(Rule::Unmodelled, detail);
            }
        };
        let (width, polynomial) = (self.width(), self.words.at(POL));
        let beyond = u64::from(polynomial) >> width != 0;
        if polynomial & 1 == 0 || beyond {
            let detail = format!("polynomial {polynomial:#x} of {width} bits");
            access.broken(Rule::CrcSetup, detail);
        }
        for bit in (0..8 * bytes).rev() {
            let out = (self.remainder >> (width - 1) ^ value >> bit) & 1;
            let shifted = (u64::from(self.remainder) << 1) as u32;
            let kept = shifted & (u64::MAX >> (64 - width)) as u32;
            self.remainder = if out == 1 { kept ^ polynomial } else { kept };
        }
    }

    /// A write to the data register, of `width` bytes.
    pub fn write_data(&mut self, value: u32, width: usize, access: &mut Access) {
        self.take(value, width as u32, access);
    }
}

impl Peripheral for Crc {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "dr16" | "dr32" | "dr8" => match Cr(self.words.at(CR)).rev_out() {
                RevOut::NORMAL => self.remainder,
                RevOut::REVERSED => self.remainder.reverse_bits() >> (32 - self.width()),
            },
            _ => self.words.get(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "dr16" | "dr32" | "dr8" => self.take(value, 4, access),
            "cr" => {
                // The reset bit goes by itself.
                self.words.set(register, value & !1);
                if value & 1 == 1 {
                    self.remainder = self.words.at(INIT);
                }
            }
            "init" => {
                self.words.set(register, value);
                self.remainder = value;
            }
            "pol" | "idr" => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("CRC.{other} is written")),
        }
    }
}
