//! What the chip's manuals forbid or warn of. A broken rule fails the run; its name says which.

use crate::time::{Ticks, to_ns};
use std::fmt;

macro_rules! rules {
    ($($(#[doc = $what:literal])+ $rule:ident = $name:literal,)*) => {
        /// The rules.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Rule { $($(#[doc = $what])+ $rule,)* }

        impl Rule {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$rule,)*];

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$rule => $name,)* }
            }

            /// What it says.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$rule => concat!($($what,)+),)* }
            }
        }
    };
}

rules! {
    /// An address of the peripherals holds a register, and the model knows it.
    Unmodelled = "unmodelled-register",
    /// A reserved bit keeps its reset value.
    ReservedBit = "reserved-bit",
    /// A register that can only be read is not written.
    ReadOnly = "read-only-register",
    /// A register is accessed in a width that it has.
    AccessWidth = "access-width",
    /// A peripheral is not touched before its clock is on.
    PeripheralClock = "peripheral-clock",
    /// The PLL's input, output and division stay within its range, and change only while it is off.
    Pll = "pll",
    /// The processor's clock is no faster than the regulator's range allows.
    VoltageRange = "voltage-range",
    /// The flash's wait states are enough for the clock.
    FlashLatency = "flash-latency",
    /// A step from 80 MHz or less to more goes over half the speed for 1 us (RM0440, 7.2.7).
    ClockStep = "clock-step",
    /// The bus prescaler is written before the clock's source changes, not with it.
    PrescalerFirst = "prescaler-first",
    /// A pin's alternate function is one that it has.
    AlternateFunction = "alternate-function",
    /// A line that a part listens to is driven or pulled.
    FloatingLine = "floating-line",
    /// A pulse of CONVST is long enough for the converter with the edges that the pin's speed gives it.
    ConvstWidth = "convst-width",
    /// The SPI clock is one that the converters take, in the mode that they want.
    SpiMode = "spi-mode",
    /// No byte is written to a full SPI FIFO, read from an empty one, or lost in one.
    SpiFifo = "spi-fifo",
    /// A chip is selected with an empty receive FIFO: a stale byte shifts all that follow.
    SpiStale = "spi-stale-byte",
    /// A chip select changes only while the bus is idle.
    SpiSelect = "spi-select",
    /// A DMA channel is enabled only when its count has been set.
    DmaSetup = "dma-setup",
    /// A DMA channel's registers are written only while it is off.
    DmaWhileOn = "dma-while-enabled",
    /// A DMA channel's memory is one that the controller reaches: not the CCM RAM at 0x1000_0000.
    DmaAddress = "dma-address",
    /// A DMA channel listens to the request line of the register that it serves, in its direction.
    DmaRequest = "dma-request",
    /// The check sum's polynomial is odd and no longer than its size.
    CrcSetup = "crc-setup",
    /// The serial line's rate is within 2 % of the motion controller's.
    BaudRate = "baud-rate",
    /// The converter of the temperature runs as the manual says: regulator, calibration, enable, start, read.
    AdcSequence = "adc-sequence",
    /// A conversion that began more than 1 ms after the one before is not used (ES0430, 2.7.7).
    AdcStale = "adc-stale",
    /// The watchdog runs before anything is waited for.
    WatchdogFirst = "watchdog-first",
    /// The watchdog does not reset the chip.
    Watchdog = "watchdog",
    /// The watchdog's registers are written only after their key.
    WatchdogKey = "watchdog-key",
    /// The supply detector warns before the brown-out reset comes.
    SupplyWarning = "supply-warning",
    /// The flash controller is given its keys, in order, and only while it is locked.
    FlashKey = "flash-key",
    /// The flash controller's registers are written only while it is unlocked and idle.
    FlashLocked = "flash-locked",
    /// Error flags of the past are cleared before the next operation.
    FlashSticky = "flash-sticky-error",
    /// Only what is erased is programmed.
    FlashErased = "flash-not-erased",
    /// Flash is programmed by two aligned words, one after the other.
    FlashDoubleWord = "flash-double-word",
    /// The data cache is off while flash is erased or programmed (ES0430, 2.2.2).
    FlashDataCache = "flash-data-cache",
    /// A cache is reset before it is switched on again after what it holds has changed: data of the flash, or both banks' places.
    FlashStaleCache = "flash-stale-cache",
    /// The bank that code runs from is neither erased nor programmed.
    FlashSameBank = "flash-same-bank",
    /// A bank is not read while it is erased or programmed: the processor would stand still, up to 25 ms (RM0440, 5.3.4).
    FlashReadWhileWrite = "flash-read-while-write",
    /// The banks change places only while code runs from RAM, with prefetch and both caches off and the controller idle.
    BankSwap = "bank-swap",
    /// Option bytes are written with their own keys, while the controller is idle, and take effect by a launch (RM0440, 3.4.2).
    OptionBytes = "option-bytes",
    /// The processor does not fault: no access to what is not there or forbidden.
    Fault = "fault",
    /// The image does not reset the chip unasked.
    Reset = "reset",
}

/// A rule broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Which.
    pub rule: Rule,
    /// When.
    pub at: Ticks,
    /// What was seen.
    pub detail: String,
    /// How often.
    pub times: u32,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            rule,
            at,
            detail,
            times,
        } = self;
        write!(f, "{}: {detail} (at {} us", rule.name(), to_ns(*at) / 1000)?;
        match times {
            1 => write!(f, ")"),
            _ => write!(f, ", {times} times)"),
        }
    }
}

/// Rules broken so far; the same twice is one.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    list: Vec<Violation>,
}

impl Findings {
    /// Notes a broken rule.
    pub fn add(&mut self, rule: Rule, at: Ticks, detail: String) {
        let same = |known: &&mut Violation| known.rule == rule && known.detail == detail;
        match self.list.iter_mut().find(same) {
            Some(known) => known.times += 1,
            None => self.list.push(Violation {
                rule,
                at,
                detail,
                times: 1,
            }),
        }
    }

    /// All, in the order in which they were first seen.
    pub fn list(&self) -> &[Violation] {
        &self.list
    }

    /// Forgets one kind: for a check that provokes it.
    pub fn forgive(&mut self, rule: Rule) {
        self.list.retain(|known| known.rule != rule);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart_and_the_same_twice_is_one() {
        let mut names: Vec<&str> = Rule::ALL.iter().map(|rule| rule.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Rule::ALL.len());
        let mut findings = Findings::default();
        for at in [5, 6] {
            findings.add(Rule::Pll, at, "twice".into());
        }
        findings.add(Rule::Pll, 7, "other".into());
        let counts: Vec<_> = findings.list().iter().map(|v| (v.at, v.times)).collect();
        assert_eq!(counts, [(5, 2), (7, 1)]);
    }
}
