//! A DMA controller and the multiplexer of its request lines: transfers between a peripheral's data register and memory, one item a request.
//!
//! A transfer takes no time here: on the chip it takes some cycles of the bus. Memory is read from bank 1 of the flash, and from RAM.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use stm32_metapac::bdma::regs::Cr;
use stm32_metapac::bdma::vals::Dir;

/// Channels of a controller.
pub const CHANNELS: usize = 8;
/// Where channel registers begin, and how far the channels lie apart (RM0440, 12.6.7).
const FIRST: u32 = 0x08;
const STRIDE: u32 = 0x14;
/// Flags of a channel in ISR, four bits each (RM0440, 12.6.1).
const GLOBAL: u32 = 1;
const COMPLETE: u32 = 1 << 1;
const HALF: u32 = 1 << 2;
const ERROR: u32 = 1 << 3;
/// Bits of CCR that may change while a channel is on: the enable bit and those of the interrupts.
const CHANGE_WHILE_ON: u32 = 0b1111;
/// Memory that the controller reaches: SRAM1 and SRAM2. The CCM RAM has no window for it at 0x1000_0000 (RM0440, 2.1).
pub const RAM: std::ops::Range<u32> = 0x2000_0000..0x2001_8000;
/// Memory that it reads besides in the model: bank 1.
const FLASH: std::ops::Range<u32> = 0x0800_0000..0x0804_0000;

/// One item that is to be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Where in memory.
    pub memory: u32,
    /// Which register.
    pub peripheral: u32,
    /// Whether it goes to the peripheral.
    pub to_peripheral: bool,
}

/// The controller.
#[derive(Debug)]
pub struct Dma {
    words: Words,
    flags: u32,
    /// Items left, and items of a whole round.
    left: [u32; CHANNELS],
    round: [u32; CHANNELS],
    /// Channels that have just been switched on.
    enabled: u32,
}

impl Default for Dma {
    fn default() -> Self {
        Self::after_reset()
    }
}

impl Dma {
    /// After reset: all zeros.
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[]),
            flags: 0,
            left: [0; CHANNELS],
            round: [0; CHANNELS],
            enabled: 0,
        }
    }

    fn cr(&self, channel: usize) -> Cr {
        Cr(self.words.at(FIRST + STRIDE * channel as u32))
    }

    fn par(&self, channel: usize) -> u32 {
        self.words.at(FIRST + STRIDE * channel as u32 + 8)
    }

    fn mar(&self, channel: usize) -> u32 {
        self.words.at(FIRST + STRIDE * channel as u32 + 12)
    }

    /// Whether a channel serves requests.
    pub fn runs(&self, channel: usize) -> bool {
        self.cr(channel).en() && self.left[channel] > 0
    }

    /// A channel's priority; of two of the same the lower number comes first.
    pub fn priority(&self, channel: usize) -> u8 {
        self.cr(channel).pl().to_bits()
    }

    /// Channels that have been switched on since the last call.
    pub fn take_enabled(&mut self) -> impl Iterator<Item = usize> + use<> {
        let enabled = std::mem::take(&mut self.enabled);
        (0..CHANNELS).filter(move |channel| enabled >> channel & 1 == 1)
    }

    /// The peripheral's register that a channel serves, and whether data go there.
    pub fn target(&self, channel: usize) -> (u32, bool) {
        let to_peripheral = self.cr(channel).dir() == Dir::FROM_MEMORY;
        (self.par(channel), to_peripheral)
    }

    /// Where a channel takes what it sends, if that is in RAM, and how many bytes.
    pub fn source_in_ram(&self, channel: usize) -> Option<(u32, usize)> {
        let (cr, memory) = (self.cr(channel), self.mar(channel));
        let sends = cr.dir() == Dir::FROM_MEMORY && RAM.contains(&memory);
        let bytes = if cr.minc() {
            self.left[channel] as usize
        } else {
            1
        };
        sends.then_some((memory, bytes))
    }

    /// Interrupt lines that are up, a bit a channel.
    pub fn interrupts(&self) -> u32 {
        if self.flags == 0 {
            return 0;
        }
        let up = |channel: usize| {
            let (cr, flags) = (self.cr(channel).0, self.flags >> (4 * channel));
            // TCIE, HTIE and TEIE stand where TCIF, HTIF and TEIF do.
            cr & flags & (COMPLETE | HALF | ERROR) != 0
        };
        (0..CHANNELS).fold(0, |lines, channel| {
            lines | u32::from(up(channel)) << channel
        })
    }

    /// The item that comes next on a running channel; it counts as moved. None if the controller cannot reach its memory.
    pub fn next_item(&mut self, channel: usize, access: &mut Access) -> Option<Item> {
        let cr = self.cr(channel);
        let done = self.round[channel] - self.left[channel];
        let step = |increments: bool| if increments { done } else { 0 };
        let (peripheral, to_peripheral) = self.target(channel);
        let memory = self.mar(channel).wrapping_add(step(cr.minc()));
        let reachable = RAM.contains(&memory) || to_peripheral && FLASH.contains(&memory);
        if !reachable {
            let detail = format!("channel {}: {memory:#010x} is out of reach", channel + 1);
            access.broken(Rule::DmaAddress, detail);
            self.flags |= (ERROR | GLOBAL) << (4 * channel);
            self.switch_off(channel);
            return None;
        }
        self.left[channel] -= 1;
        if self.left[channel] == self.round[channel] / 2 {
            self.flags |= (HALF | GLOBAL) << (4 * channel);
        }
        if self.left[channel] == 0 {
            self.flags |= (COMPLETE | GLOBAL) << (4 * channel);
            if cr.circ() {
                self.left[channel] = self.round[channel];
            }
        }
        Some(Item {
            memory,
            peripheral,
            to_peripheral,
        })
    }

    fn switch_off(&mut self, channel: usize) {
        let mut cr = self.cr(channel);
        cr.set_en(false);
        self.words.put(FIRST + STRIDE * channel as u32, cr.0);
    }

    fn write_cr(&mut self, channel: usize, value: u32, access: &mut Access) {
        let (before, now) = (self.cr(channel), Cr(value));
        let number = channel + 1;
        let changed = before.0 ^ now.0;
        if before.en() && now.en() && changed & !CHANGE_WHILE_ON != 0 {
            let detail = format!("channel {number}: its set-up changes");
            access.broken(Rule::DmaWhileOn, detail);
        }
        self.words.put(FIRST + STRIDE * channel as u32, value);
        if !now.en() || before.en() {
            return;
        }
        self.enabled |= 1 << channel;
        if self.left[channel] == 0 || self.left[channel] != self.round[channel] {
            let detail = format!("channel {number}: its count has not been set since it last ran");
            access.broken(Rule::DmaSetup, detail);
        }
        if now.mem2mem() || now.pinc() || now.psize().to_bits() != 0 || now.msize().to_bits() != 0 {
            let detail = format!("DMA channel {number}: the model moves bytes of one register");
            access.broken(Rule::Unmodelled, detail);
        }
    }
}

impl Peripheral for Dma {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "isr" => self.flags,
            "ifcr" => 0,
            "ndtr" => self.left[register.index as usize],
            _ => self.words.get(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        let channel = register.index as usize;
        match register.name {
            "ifcr" => {
                // A channel's global bit takes all four.
                let all = (0..CHANNELS)
                    .filter(|channel| value >> (4 * channel) & GLOBAL == 1)
                    .fold(value, |bits, channel| bits | 0xF << (4 * channel));
                self.flags &= !all;
                for channel in 0..CHANNELS {
                    if self.flags >> (4 * channel) & (COMPLETE | HALF | ERROR) == 0 {
                        self.flags &= !(GLOBAL << (4 * channel));
                    }
                }
            }
            "cr" => self.write_cr(channel, value, access),
            "ndtr" | "par" | "mar" => {
                if self.cr(channel).en() {
                    let detail = format!("channel {}: {} is written", channel + 1, register.name);
                    access.broken(Rule::DmaWhileOn, detail);
                }
                if register.name == "ndtr" {
                    self.left[channel] = value;
                    self.round[channel] = value;
                }
                self.words.set(register, value);
            }
            other => access.broken(Rule::Unmodelled, format!("DMA1.{other} is written")),
        }
    }
}

/// The multiplexer: which request line each channel listens to. Synchronisation and request generators are not modelled.
#[derive(Debug)]
pub struct Dmamux {
    words: Words,
}

impl Dmamux {
    /// After reset: no channel listens.
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[]),
        }
    }

    /// Number of the request line that a channel of the first controller listens to.
    pub fn request(&self, channel: usize) -> u32 {
        self.words.at(4 * channel as u32) & 0x7F
    }
}

impl Peripheral for Dmamux {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            // The request's number alone.
            "ccr" if value & !0x7F == 0 => self.words.set(register, value),
            other => {
                let detail = format!("DMAMUX1.{other}({}): {value:#x}", register.index);
                access.broken(Rule::Unmodelled, detail);
            }
        }
    }
}
