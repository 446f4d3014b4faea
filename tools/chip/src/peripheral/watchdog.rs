//! The independent watchdog: 32 kHz, a key before every change, a reset unless it is fed.

use super::{Access, Peripheral};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, TICK_HZ, Ticks};

/// Ticks of a cycle of the low-speed oscillator, 32 kHz.
pub const LSI: Ticks = TICK_HZ / 32_000;
/// A new prescaler or reload value takes up to five of the low-speed oscillator's cycles (RM0440, 42.4.4).
const UPDATE: Ticks = 5 * LSI;

/// The peripheral.
#[derive(Debug)]
pub struct Iwdg {
    runs: bool,
    open: bool,
    prescaler: u32,
    reload: u32,
    window: u32,
    fed_at: Ticks,
    prescaler_until: Ticks,
    reload_until: Ticks,
    due: Ticks,
    expired: bool,
}

impl Iwdg {
    /// After reset.
    pub fn after_reset() -> Self {
        Self {
            runs: false,
            open: false,
            prescaler: 0,
            reload: 0xFFF,
            window: 0xFFF,
            fed_at: 0,
            prescaler_until: 0,
            reload_until: 0,
            due: NEVER,
            expired: false,
        }
    }

    /// Whether it has been started.
    pub fn runs(&self) -> bool {
        self.runs
    }

    /// Whether it wants a reset.
    pub fn expired(&self) -> bool {
        self.expired
    }

    /// It stood still for so long.
    pub fn stood_still(&mut self, duration: Ticks) {
        self.fed_at += duration;
        self.reschedule();
    }

    fn period(&self) -> Ticks {
        let divider = 4u64 << self.prescaler.min(6);
        (u64::from(self.reload) + 1) * divider * LSI
    }

    fn reschedule(&mut self) {
        self.due = match self.runs {
            true => self.fed_at + self.period(),
            false => NEVER,
        };
    }

    fn write_key(&mut self, value: u32, access: &mut Access) {
        match value & 0xFFFF {
            0xCCCC => self.runs = true,
            0x5555 => self.open = true,
            0xAAAA => self.open = false,
            other => access.broken(Rule::WatchdogKey, format!("IWDG.kr: {other:#x} is no key")),
        }
        if value & 0xFFFF != 0x5555 {
            self.open = false;
            self.fed_at = access.now;
        }
        self.reschedule();
    }
}

impl Peripheral for Iwdg {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "pr" => self.prescaler,
            "rlr" => self.reload,
            "winr" => self.window,
            _ => 0,
        }
    }

    fn read(&mut self, register: &Register, access: &mut Access) -> u32 {
        match register.name {
            "sr" => {
                u32::from(access.now < self.prescaler_until)
                    | u32::from(access.now < self.reload_until) << 1
            }
            _ => self.peek(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        if register.name == "kr" {
            return self.write_key(value, access);
        }
        let until = match register.name {
            "pr" => &mut self.prescaler_until,
            _ => &mut self.reload_until,
        };
        if !self.open || access.now < *until {
            let why = match self.open {
                true => "while the value before is still taken over",
                false => "without its key",
            };
            return access.broken(
                Rule::WatchdogKey,
                format!("IWDG.{} is written {why}", register.name),
            );
        }
        *until = access.now + UPDATE;
        match register.name {
            "pr" => self.prescaler = value,
            "rlr" => self.reload = value,
            _ => self.window = value,
        }
        self.reschedule();
    }

    fn next(&self) -> Ticks {
        self.due
    }

    fn advance(&mut self, access: &mut Access) {
        if access.now >= self.due {
            self.expired = true;
            self.due = NEVER;
        }
    }
}
