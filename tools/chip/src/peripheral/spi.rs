//! SPI as master: 8 bits, two FIFOs of four bytes, chip selects by software; its bytes are moved by the processor or by DMA.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks};
use std::collections::VecDeque;
use stm32_metapac::spi::regs::{Cr1, Cr2, Sr};
use stm32_metapac::spi::vals::{Cpha, Cpol, Ds, Frlvl, Frxth, Ftlvl, Mstr};

/// Bytes of a FIFO.
const FIFO_BYTES: usize = 4;
/// The fastest clock that the AD7606C takes at 3.3 V, hertz (its data sheet, serial interface timing: 16.6 ns).
const FASTEST_HZ: u32 = 60_000_000;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;

/// The peripheral.
#[derive(Debug)]
pub struct Spi {
    name: &'static str,
    words: Words,
    to_send: VecDeque<u8>,
    received: VecDeque<u8>,
    /// The byte on the wire, and when it is through.
    shifting: Option<(u8, Ticks)>,
    overrun: bool,
    /// A byte that has gone through and waits for its answer.
    gone: Option<u8>,
    /// When the newest of them began and ended.
    gone_between: [Ticks; 2],
}

impl Spi {
    /// SPI1 or SPI2 after reset (RM0440, 39.9).
    pub fn after_reset(name: &'static str) -> Self {
        Self {
            name,
            words: Words::after_reset(&[(CR2, 0x0700), (0x10, 0x0007)]),
            to_send: VecDeque::new(),
            received: VecDeque::new(),
            shifting: None,
            overrun: false,
            gone: None,
            gone_between: [0; 2],
        }
    }

    /// Whether a byte is on the wire or waits.
    pub fn busy(&self) -> bool {
        self.shifting.is_some() || !self.to_send.is_empty()
    }

    /// Bytes that nobody has read.
    pub fn unread(&self) -> usize {
        self.received.len()
    }

    /// A byte that has gone out; [`Spi::answer`] is what came meanwhile.
    pub fn take_gone(&mut self) -> Option<u8> {
        self.gone.take()
    }

    /// When the newest byte that has gone out began, and when it ended.
    pub fn gone_between(&self) -> [Ticks; 2] {
        self.gone_between
    }

    /// What came in.
    pub fn answer(&mut self, byte: u8, access: &mut Access) {
        if self.received.len() == FIFO_BYTES {
            self.overrun = true;
            access.broken(Rule::SpiFifo, "a byte came to a full FIFO");
        } else {
            self.received.push_back(byte);
        }
    }

    /// Its request for a DMA transfer: of a byte that has come, or for one to be sent.
    pub fn requests(&self, receives: bool) -> bool {
        let (status, cr2) = (self.status(), Cr2(self.words.at(CR2)));
        match receives {
            true => cr2.rxdmaen() && status.rxne(),
            false => cr2.txdmaen() && status.txe() && Cr1(self.words.at(CR1)).spe(),
        }
    }

    /// A DMA transfer takes the oldest byte that has come.
    pub fn dma_read(&mut self) -> u8 {
        self.received.pop_front().unwrap_or(0)
    }

    /// A DMA transfer brings a byte to send.
    pub fn dma_write(&mut self, byte: u8, access: &mut Access) {
        self.write_data(byte, access);
    }

    fn status(&self) -> Sr {
        let cr2 = Cr2(self.words.at(CR2));
        let enough = match cr2.frxth() {
            Frxth::QUARTER => 1,
            _ => 2,
        };
        let level = |bytes: usize| match bytes {
            0 => 0,
            1 => 1,
            2 | 3 => 2,
            _ => 3,
        };
        let mut sr = Sr(0);
        sr.set_rxne(self.received.len() >= enough);
        sr.set_txe(self.to_send.len() <= FIFO_BYTES / 2);
        sr.set_ovr(self.overrun);
        sr.set_bsy(self.busy());
        sr.set_frlvl(Frlvl::from_bits(level(self.received.len())));
        sr.set_ftlvl(Ftlvl::from_bits(level(self.to_send.len())));
        sr
    }

    fn byte_ticks(&self, access: &Access) -> Ticks {
        let divider = 2u64 << Cr1(self.words.at(CR1)).br().to_bits();
        8 * divider * access.clocks.cycle2()
    }

    fn write_cr1(&mut self, value: u32, access: &mut Access) {
        let (before, now) = (Cr1(self.words.at(CR1)), Cr1(value));
        let set_while_on = before.0 & !(1 << 6) != now.0 & !(1 << 6);
        if before.spe() && now.spe() && set_while_on {
            access.broken(
                Rule::SpiMode,
                format!("{}.cr1 changes while it is on", self.name),
            );
        }
        if now.spe() && !before.spe() {
            check_mode(self.name, now, Cr2(self.words.at(CR2)), access);
        }
        if before.spe() && !now.spe() {
            if self.busy() {
                let detail = format!("{} is switched off while a byte is under way", self.name);
                access.broken(Rule::SpiMode, detail);
            }
            self.to_send.clear();
            self.shifting = None;
        }
        self.words.put(CR1, value);
    }

    fn write_data(&mut self, byte: u8, access: &mut Access) {
        if !Cr1(self.words.at(CR1)).spe() {
            let detail = format!("a byte is written while {} is off", self.name);
            return access.broken(Rule::SpiFifo, detail);
        }
        if self.shifting.is_none() {
            self.shifting = Some((byte, access.now + self.byte_ticks(access)));
        } else if self.to_send.len() < FIFO_BYTES {
            self.to_send.push_back(byte);
        } else {
            access.broken(Rule::SpiFifo, "a byte is written to a full FIFO");
        }
    }
}

fn check_mode(name: &str, cr1: Cr1, cr2: Cr2, access: &mut Access) {
    // Both buses of the peripherals run at the same speed here.
    let hz = access.clocks.pclk2_hz / (2 << cr1.br().to_bits());
    if hz > FASTEST_HZ {
        access.broken(
            Rule::SpiMode,
            format!("{name} at {hz} Hz, the converters take {FASTEST_HZ} Hz"),
        );
    }
    // AD7606C: clock idles high, data are taken at its falling edge.
    let right = cr1.cpol() == Cpol::IDLE_HIGH && cr1.cpha() == Cpha::FIRST_EDGE;
    if !right || cr1.mstr() != Mstr::MASTER || cr2.ds() != Ds::BITS8 {
        let detail = format!("{name}: the converters want a master in mode 2, 8 bits");
        access.broken(Rule::SpiMode, detail);
    }
    if !(cr1.ssm() && cr1.ssi()) {
        let detail = format!("{name}: NSS is neither a pin nor held high by software");
        access.broken(Rule::SpiMode, detail);
    }
}

impl Peripheral for Spi {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "sr" => self.status().0,
            "dr16" | "dr8" => 0,
            _ => self.words.get(register),
        }
    }

    fn read(&mut self, register: &Register, access: &mut Access) -> u32 {
        match register.name {
            "dr16" | "dr8" => match self.received.pop_front() {
                Some(byte) => u32::from(byte),
                None => {
                    access.broken(Rule::SpiFifo, "a byte is read from an empty FIFO");
                    0
                }
            },
            "sr" => {
                let status = self.status();
                self.overrun = false;
                status.0
            }
            _ => self.peek(register),
        }
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "dr16" | "dr8" => self.write_data(value as u8, access),
            "cr1" => self.write_cr1(value, access),
            "cr2" => self.words.set(register, value),
            other => {
                access.broken(
                    Rule::Unmodelled,
                    format!("{}.{other} is written", self.name),
                );
            }
        }
    }

    fn next(&self) -> Ticks {
        self.shifting.map_or(NEVER, |(_, end)| end)
    }

    /// One byte a call: its answer must come before the next.
    fn advance(&mut self, access: &mut Access) {
        if let Some((byte, end)) = self.shifting
            && access.now >= end
        {
            self.gone = Some(byte);
            self.gone_between = [end - self.byte_ticks(access), end];
            let next = self.to_send.pop_front();
            self.shifting = next.map(|byte| (byte, end + self.byte_ticks(access)));
        }
    }
}
