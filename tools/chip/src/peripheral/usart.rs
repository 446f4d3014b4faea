//! USART with FIFOs of eight bytes, 8 bits, no parity.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, TICK_HZ, Ticks};
use std::collections::VecDeque;
use stm32_metapac::usart::regs::{Cr1, Cr3, Isr};

/// Bytes of a FIFO.
const FIFO_BYTES: usize = 8;
/// What the motion controller speaks, bits a second, and how far off a line may be (RM0440, table 347: 3.3 % in all, so
/// half of it for either side).
const LINE_HZ: u32 = 1_000_000;
const TOLERANCE_PER_MILLE: u32 = 16;
/// Bits of a byte on the line: start, eight, stop.
const BITS: u64 = 10;

const CR1: u32 = 0x00;
const CR3: u32 = 0x08;
const BRR: u32 = 0x0C;

/// The peripheral.
#[derive(Debug)]
pub struct Usart {
    words: Words,
    to_send: VecDeque<u8>,
    received: VecDeque<u8>,
    sent_at: Option<Ticks>,
    look_at: Ticks,
    overrun: bool,
    complete: bool,
    /// A byte whose start bit has just gone out.
    begun: Option<u8>,
}

impl Usart {
    /// After reset.
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[]),
            to_send: VecDeque::new(),
            received: VecDeque::new(),
            sent_at: None,
            look_at: NEVER,
            overrun: false,
            complete: true,
            begun: None,
        }
    }

    fn cr1(&self) -> Cr1 {
        Cr1(self.words.at(CR1))
    }

    fn depth(&self) -> usize {
        if self.cr1().fifoen() { FIFO_BYTES } else { 1 }
    }

    /// A byte that begins to go out now.
    pub fn take_begun(&mut self) -> Option<u8> {
        self.begun.take()
    }

    /// Whether it listens.
    pub fn listens(&self) -> bool {
        self.cr1().ue() && self.cr1().re()
    }

    /// A byte that has come.
    pub fn receive(&mut self, byte: u8) {
        if self.received.len() < self.depth() {
            self.received.push_back(byte);
        } else if !Cr3(self.words.at(CR3)).ovrdis() {
            self.overrun = true;
        }
    }

    /// Whether it interrupts.
    pub fn interrupts(&self) -> bool {
        let (cr1, status) = (self.cr1(), self.status());
        cr1.rxneie() && (status.rxne() || status.ore())
            || cr1.txeie() && status.txe()
            || cr1.tcie() && status.tc()
    }

    fn status(&self) -> Isr {
        let mut isr = Isr(0);
        isr.set_rxne(!self.received.is_empty());
        isr.set_ore(self.overrun);
        isr.set_txe(self.to_send.len() < self.depth());
        isr.set_tc(self.complete && self.to_send.is_empty() && self.sent_at.is_none());
        isr.set_teack(self.cr1().ue() && self.cr1().te());
        isr.set_reack(self.listens());
        isr.set_txfe(self.to_send.is_empty());
        isr.set_rxff(self.received.len() == self.depth());
        isr
    }

    fn byte_ticks(&self, access: &Access) -> Ticks {
        let hz = access.clocks.pclk2_hz / self.words.at(BRR).max(1);
        BITS * TICK_HZ / u64::from(hz.max(1))
    }

    fn write_cr1(&mut self, value: u32, access: &mut Access) {
        let (before, now) = (self.cr1(), Cr1(value));
        self.words.put(CR1, value);
        if now.ue() && !before.ue() {
            let hz = access.clocks.pclk2_hz / self.words.at(BRR).max(1);
            if hz.abs_diff(LINE_HZ) > LINE_HZ / 1000 * TOLERANCE_PER_MILLE {
                let detail = format!("USART1 at {hz} bits/s, the controller at {LINE_HZ}");
                access.broken(Rule::BaudRate, detail);
            }
        }
        if before.ue() && now.ue() && before.fifoen() != now.fifoen() {
            access.broken(Rule::BaudRate, "USART1: FIFO mode changes while it is on");
        }
        self.look_at = match self.listens() {
            true => access.now,
            false => NEVER,
        };
    }

    fn begin(&mut self, access: &mut Access) {
        if self.sent_at.is_none()
            && self.cr1().ue()
            && self.cr1().te()
            && let Some(byte) = self.to_send.pop_front()
        {
            self.begun = Some(byte);
            self.complete = false;
            self.sent_at = Some(access.now + self.byte_ticks(access));
        }
    }
}

impl Peripheral for Usart {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "isr" => self.status().0,
            "rdr" => self.received.front().map_or(0, |byte| u32::from(*byte)),
            _ => self.words.get(register),
        }
    }

    fn read(&mut self, register: &Register, _: &mut Access) -> u32 {
        let value = self.peek(register);
        if register.name == "rdr" {
            self.received.pop_front();
        }
        value
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr1" => self.write_cr1(value, access),
            "brr" | "cr2" | "cr3" | "presc" => {
                if self.cr1().ue() && self.words.get(register) != value {
                    let detail = format!("USART1.{} changes while it is on", register.name);
                    access.broken(Rule::BaudRate, detail);
                }
                self.words.set(register, value);
            }
            "tdr" => {
                if self.to_send.len() < self.depth() {
                    self.to_send.push_back(value as u8);
                }
                self.begin(access);
            }
            "icr" => {
                self.overrun &= value & 1 << 3 == 0;
                self.complete |= value & 1 << 6 != 0;
            }
            other => access.broken(Rule::Unmodelled, format!("USART1.{other} is written")),
        }
    }

    fn next(&self) -> Ticks {
        self.look_at.min(self.sent_at.unwrap_or(NEVER))
    }

    fn advance(&mut self, access: &mut Access) {
        if self.sent_at.is_some_and(|end| access.now >= end) {
            self.sent_at = None;
            self.complete = true;
            self.begin(access);
        }
        if access.now >= self.look_at {
            // A byte takes so long, so that looking as often loses none.
            self.look_at = access.now + self.byte_ticks(access);
        }
    }
}
