//! A port of 16 pins.

use super::{Access, Peripheral, Words};
use crate::registers::{self, Register};
use crate::rule::Rule;

const MODER: u32 = 0x00;
const OTYPER: u32 = 0x04;
const OSPEEDR: u32 = 0x08;
const PUPDR: u32 = 0x0C;
const ODR: u32 = 0x14;
const AFR: u32 = 0x20;

/// What a pin does to its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Drives it.
    Level(bool),
    /// A peripheral drives it: the alternate function's number.
    Function(u8),
    /// A resistor pulls it.
    Pulled(bool),
    /// Nothing.
    Floating,
}

/// The peripheral.
#[derive(Debug)]
pub struct Gpio {
    letter: char,
    words: Words,
    /// Levels of the lines.
    pub lines: u32,
}

impl Gpio {
    /// After reset: all pins analog, but for the debugger's (RM0440, 9.4).
    pub fn after_reset(port: usize) -> Self {
        let (mode, speed, pull) = match port {
            0 => (0xABFF_FFFF, 0x0C00_0000, 0x6400_0000),
            1 => (0xFFFF_FEBF, 0x0000_00C0, 0x0000_0100),
            _ => (0xFFFF_FFFF, 0, 0),
        };
        Self {
            letter: char::from(b'A' + port as u8),
            words: Words::after_reset(&[(MODER, mode), (OSPEEDR, speed), (PUPDR, pull)]),
            lines: 0,
        }
    }

    /// What a pin does to its line.
    pub fn drive(&self, pin: u32) -> Drive {
        let high = self.words.at(ODR) >> pin & 1 == 1;
        let open_drain = self.words.at(OTYPER) >> pin & 1 == 1;
        match self.words.at(MODER) >> (2 * pin) & 3 {
            1 if !(open_drain && high) => Drive::Level(high),
            2 => Drive::Function(self.function(pin)),
            _ => match self.pull(pin) {
                1 => Drive::Pulled(true),
                2 => Drive::Pulled(false),
                _ => Drive::Floating,
            },
        }
    }

    /// A resistor's bits: 0 none, 1 up, 2 down.
    pub fn pull(&self, pin: u32) -> u32 {
        self.words.at(PUPDR) >> (2 * pin) & 3
    }

    fn function(&self, pin: u32) -> u8 {
        (self.words.at(AFR + pin / 8 * 4) >> (pin % 8 * 4) & 0xF) as u8
    }

    /// Time that an edge of this pin takes at 50 pF, by its speed setting (DS12288, I/O AC characteristics), nanoseconds.
    pub fn edge_ns(&self, pin: u32) -> u64 {
        [25, 9, 6, 4][(self.words.at(OSPEEDR) >> (2 * pin) & 3) as usize]
    }

    fn name(&self, pin: u32) -> String {
        format!("P{}{pin}", self.letter)
    }

    /// Pins that have just been given to a peripheral, and what is wrong about it.
    fn check_functions(&self, before: u32, access: &mut Access) {
        let now = self.words.at(MODER);
        for pin in (0..16).filter(|pin| before >> (2 * pin) & 3 != 2 && now >> (2 * pin) & 3 == 2) {
            let function = self.function(pin);
            if !registers::has_function(&self.name(pin), function) {
                let detail = format!("{} has no function {function}", self.name(pin));
                access.broken(Rule::AlternateFunction, detail);
            }
        }
    }
}

impl Peripheral for Gpio {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "idr" => self.lines,
            _ => self.words.get(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "bsrr" => {
                let odr = self.words.at(ODR) & !(value >> 16) | value & 0xFFFF;
                self.words.put(ODR, odr);
            }
            "brr" => {
                let odr = self.words.at(ODR) & !value;
                self.words.put(ODR, odr);
            }
            "moder" => {
                let before = self.words.at(MODER);
                self.words.set(register, value);
                self.check_functions(before, access);
            }
            "otyper" | "ospeedr" | "pupdr" | "odr" | "afr" => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("GPIO.{other} is written")),
        }
    }
}
