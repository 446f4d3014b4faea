//! The frequencies that the chip's parts run at.

use crate::time::{TICK_HZ, Ticks};

/// The internal oscillator, hertz.
pub(super) const HSI_HZ: u32 = 16_000_000;

/// Frequencies, hertz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// The chosen source.
    pub system_hz: u32,
    /// Processor and fast bus.
    pub hclk_hz: u32,
    /// First slow bus.
    pub pclk1_hz: u32,
    /// Second slow bus.
    pub pclk2_hz: u32,
}

impl Clocks {
    /// After reset.
    pub const RESET: Self = Self {
        system_hz: HSI_HZ,
        hclk_hz: HSI_HZ,
        pclk1_hz: HSI_HZ,
        pclk2_hz: HSI_HZ,
    };

    /// Ticks of a processor's cycle.
    pub fn cycle(&self) -> Ticks {
        TICK_HZ / u64::from(self.hclk_hz)
    }

    /// Ticks of a cycle of the second slow bus.
    pub fn cycle2(&self) -> Ticks {
        TICK_HZ / u64::from(self.pclk2_hz)
    }

    /// Ticks of a cycle of a timer on the first slow bus, which runs at twice the bus where that is divided.
    pub fn timer1_cycle(&self) -> Ticks {
        let divided = self.pclk1_hz != self.hclk_hz;
        TICK_HZ / u64::from(self.pclk1_hz * if divided { 2 } else { 1 })
    }
}
