//! Answers the emulated board's questions with the simulated parts.

use anyhow::Result;
use courier_sensor::emulation::{
    BACKGROUND, DATA_BYTES, FAILED, HEADER_BYTES, INTERRUPT, MAILBOX_BASE, MAILBOX_STRIDE,
    Operation, Pin, TICK_HZ, Word,
};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use embedded_io::{Read, ReadReady, Write};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hal_sim::board::SharedFlash;
use hal_sim::wire::converter::{Busy, Convst, Reset, Spi};
use hal_sim::wire::flash::PAGE_BYTES;
use hal_sim::wire::motion::Line;
use hal_sim::world::World;

use super::shared::SharedRam;
use crate::memory::TargetMemory;

/// Looks at BUSY after which a conversion is given up: 80 us.
const BUSY_LOOKS: u32 = 4096;

/// The parts at the board's pins, and the flash inside it.
pub struct Parts {
    /// Everything around the processor.
    pub world: World,
    /// The flash bank of the slots.
    pub flash: SharedFlash,
    /// Board temperature, degrees Celsius.
    pub temperature_c: f64,
    /// The status LED's level.
    pub led: bool,
    chips: [Spi; 2],
    convst: Convst,
    reset: Reset,
    busy: Busy,
    line: Line,
    last_ticks: u32,
    board_ns: u64,
}

impl Parts {
    /// A board in this world.
    pub fn new(world: World, flash: SharedFlash) -> Self {
        let wire = &world.converter;
        let (chips, convst, reset, busy) = (
            [wire.spi(0), wire.spi(1)],
            wire.convst(),
            wire.reset(),
            wire.busy(),
        );
        let line = world.motion.line();
        Self {
            chips,
            convst,
            reset,
            busy,
            line,
            world,
            flash,
            temperature_c: 25.0,
            led: false,
            last_ticks: 0,
            board_ns: 0,
        }
    }

    /// Answers every open question of both mailboxes; returns whether the image has just started.
    ///
    /// # Errors
    /// The mailboxes cannot be reached.
    pub fn answer(&mut self, ram: &mut SharedRam) -> Result<bool> {
        let mut started = false;
        for index in [INTERRUPT, BACKGROUND] {
            let base = MAILBOX_BASE + index as u32 * MAILBOX_STRIDE;
            let word = |word: Word| base + 4 * word as u32;
            let sequence = ram.read_word(word(Word::Sequence))?;
            if sequence == ram.read_word(word(Word::Done))? {
                continue;
            }
            let operation = Operation::from_word(ram.read_word(word(Word::Operation))?);
            let length = (ram.read_word(word(Word::Length))? as usize).min(DATA_BYTES);
            let argument = ram.read_word(word(Word::Argument))?;
            let mut data = [0; DATA_BYTES];
            ram.read(base + HEADER_BYTES, &mut data[..length])?;
            self.pass_time(operation, ram.read_word(word(Word::Ticks))?);
            started |= operation == Some(Operation::Boot);
            let answer = operation
                .and_then(|operation| self.carry_out(operation, argument, &mut data[..length]));
            ram.write(base + HEADER_BYTES, &data[..length])?;
            ram.write_word(word(Word::Answer), answer.unwrap_or(FAILED))?;
            ram.write_word(word(Word::Done), sequence)?;
        }
        Ok(started)
    }

    /// The board's own time since it was first switched on, nanoseconds.
    pub fn board_ns(&self) -> u64 {
        self.board_ns
    }

    /// Brings the world's time to the board's.
    fn pass_time(&mut self, operation: Option<Operation>, ticks: u32) {
        let passed = if operation == Some(Operation::Boot) {
            ticks
        } else {
            ticks.wrapping_sub(self.last_ticks)
        };
        self.last_ticks = ticks;
        // What the parts themselves took is already past, so the clock is brought up to the board's, not added to.
        self.board_ns += u64::from(passed) * (1_000_000_000 / u64::from(TICK_HZ));
        self.world.clock.advance_to_ns(self.board_ns);
    }

    fn carry_out(&mut self, operation: Operation, argument: u32, data: &mut [u8]) -> Option<u32> {
        let done = Some(0);
        match operation {
            Operation::Boot => done,
            Operation::Convert => {
                let fell = u32::from(self.convert());
                let bytes = u32::from(self.line.read_ready() == Ok(true));
                Some(fell | bytes << 1)
            }
            Operation::Spi => {
                let chip = self.chips.get_mut(argument as usize)?;
                chip.transfer_in_place(data).ok()?;
                done
            }
            Operation::SetPin => self.set_pin(argument),
            Operation::GetPin => {
                (argument == Pin::Busy as u32).then(|| u32::from(self.busy.is_high() == Ok(true)))
            }
            Operation::SerialWrite => self.line.write(data).ok().map(|count| count as u32),
            Operation::SerialRead if self.line.read_ready().ok()? => {
                self.line.read(data).ok().map(|count| count as u32)
            }
            Operation::SerialRead => done,
            Operation::FlashRead => self.flash.read(argument, data).ok().map(|()| 0),
            Operation::FlashErase => self
                .flash
                .erase(argument, argument + PAGE_BYTES as u32)
                .ok()
                .map(|()| 0),
            Operation::FlashWrite => self.flash.write(argument, data).ok().map(|()| 0),
            Operation::Temperature => {
                Some((self.temperature_c * 1000.0) as i32 as u32).map(|t| t.wrapping_add(1_000_000))
            }
        }
    }

    /// What the timer's pulse and BUSY do on the real board.
    fn convert(&mut self) -> bool {
        let _ = self.convst.set_high();
        let _ = self.convst.set_low();
        (0..BUSY_LOOKS).any(|_| self.busy.is_low() == Ok(true))
    }

    fn set_pin(&mut self, argument: u32) -> Option<u32> {
        let level = argument & 1 == 1;
        match argument >> 1 {
            pin if pin == Pin::Convst as u32 => set(&mut self.convst, level),
            pin if pin == Pin::Reset as u32 => set(&mut self.reset, level),
            pin if pin == Pin::Led as u32 => self.led = level,
            _ => return None,
        }
        Some(0)
    }
}

fn set(pin: &mut impl OutputPin, level: bool) {
    let _ = if level { pin.set_high() } else { pin.set_low() };
}
