//! What is wired to the chip's pins: `hal-sim`'s converters and motion controller, and the lamp.

use crate::time::{NEVER, Ticks, from_ns, to_ns};
use embedded_hal::digital::OutputPin;
use embedded_io::{Read, ReadReady, Write};
use hal_sim::board::SharedFlash;
use hal_sim::wire::converter::{Convst, Reset};
use hal_sim::wire::motion::Line;
use hal_sim::world::World;
use std::convert::Infallible;

/// A look at BUSY where the end of a conversion is sought.
const LOOK: Ticks = from_ns(25);

/// The parts at the chip's pins.
pub struct Surroundings {
    /// Everything around the board.
    pub world: World,
    /// Bank 2 of the chip's flash, which outlives its resets.
    pub flash: SharedFlash,
    /// The lamp's level.
    pub lamp: bool,
    /// BUSY never rises.
    pub silent: bool,
    convst: Convst,
    reset: Reset,
    line: Line,
    busy_until: Ticks,
    selected: [bool; 2],
}

impl Surroundings {
    /// A board in this world.
    pub fn new(world: World, flash: SharedFlash) -> Self {
        Self {
            convst: world.converter.convst(),
            reset: world.converter.reset(),
            line: world.motion.line(),
            world,
            flash,
            lamp: false,
            silent: false,
            busy_until: 0,
            selected: [false; 2],
        }
    }

    /// A reset: the chip's pins drive nothing, and every line of the board falls.
    pub fn release(&mut self, now: Ticks) {
        self.convst(false, now);
        self.reset(false, now);
        for chip in (0..2)
            .filter(|chip| self.selected[*chip])
            .collect::<Vec<_>>()
        {
            self.select(chip, false, now);
        }
    }

    fn arrive(&self, now: Ticks) {
        self.world.clock.advance_to_ns(to_ns(now));
    }

    /// An edge of CONVST.
    pub fn convst(&mut self, high: bool, now: Ticks) {
        self.arrive(now);
        set(&mut self.convst, high);
        if high && now >= self.busy_until {
            self.busy_until = self.conversion_end(now);
        }
    }

    /// When chip 0 takes BUSY down again.
    fn conversion_end(&self, now: Ticks) -> Ticks {
        let mut chip = self.world.converter.with_chip(0, |chip| chip.clone());
        let mut end = now;
        while chip.busy(to_ns(end)) {
            end += LOOK;
        }
        end
    }

    /// An edge of RESET.
    pub fn reset(&mut self, high: bool, now: Ticks) {
        self.arrive(now);
        set(&mut self.reset, high);
        if high {
            self.busy_until = now;
        }
    }

    /// Level of BUSY.
    pub fn busy(&self, now: Ticks) -> bool {
        !self.silent && now < self.busy_until
    }

    /// When BUSY falls; never if it is low.
    pub fn busy_falls(&self, now: Ticks) -> Ticks {
        match self.busy(now) {
            true => self.busy_until,
            false => NEVER,
        }
    }

    /// A chip select changes.
    pub fn select(&mut self, chip: usize, low: bool, now: Ticks) {
        self.arrive(now);
        self.selected[chip] = low;
        self.world.converter.with_chip(chip, |part| match low {
            true => part.select(to_ns(now)),
            false => part.deselect(),
        });
    }

    /// A byte on the bus; an undriven data line reads as ones.
    pub fn exchange(&mut self, byte: u8) -> u8 {
        let mut answer = 0xFF;
        for chip in (0..2).filter(|chip| self.selected[*chip]) {
            let converter = &self.world.converter;
            answer &= converter.with_chip(chip, |part| part.exchange(byte));
        }
        answer
    }

    /// The board sends a byte to the motion controller: its start bit is at `now`.
    pub fn send(&mut self, byte: u8, now: Ticks) {
        self.arrive(now);
        // A byte without room is lost, as on the line.
        let _ = self.line.write(&[byte]);
    }

    /// A byte that the motion controller has sent.
    pub fn receive(&mut self, now: Ticks) -> Option<u8> {
        self.arrive(now);
        let mut byte = [0];
        let ready = self.line.read_ready() == Ok(true);
        (ready && self.line.read(&mut byte) == Ok(1)).then_some(byte[0])
    }

    /// Temperature of the board, degrees Celsius.
    pub fn temperature_c(&self) -> f64 {
        self.world
            .with_courier(|courier| courier.sample().temperature_c)
    }
}

fn set(pin: &mut impl OutputPin<Error = Infallible>, high: bool) {
    let Ok(()) = pin.set_state(high.into());
}
