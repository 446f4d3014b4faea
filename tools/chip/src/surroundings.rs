//! What is wired to the chip's pins: `hal-sim`'s converters and motion controller, and the lamp.

use crate::bank::Bank;
use crate::beyond::Beyond;
use crate::host::{Host, Inputs};
use crate::time::{NEVER, Ticks, from_ns, to_ns};
use anyhow::Result;
use embedded_hal::digital::OutputPin;
use embedded_io::{Read, ReadReady, Write};
use hal_sim::board::SharedFlash;
use hal_sim::wire::clock::Clock;
use hal_sim::wire::converter::{ConverterWire, Convst, Reset};
use hal_sim::wire::motion::Line;
use hal_sim::world::World;
use std::convert::Infallible;

/// A look at BUSY where the end of a conversion is sought.
const LOOK: Ticks = from_ns(25);

/// A world in this program.
struct Near {
    world: World,
    line: Line,
}

impl Beyond for Near {
    fn send(&mut self, byte: u8, now_ns: u64) {
        self.world.clock.advance_to_ns(now_ns);
        // A byte without room is lost, as on the line.
        let _ = self.line.write(&[byte]);
    }

    fn receive(&mut self, now_ns: u64) -> Option<u8> {
        self.world.clock.advance_to_ns(now_ns);
        let mut byte = [0];
        let ready = self.line.read_ready() == Ok(true);
        (ready && self.line.read(&mut byte) == Ok(1)).then_some(byte[0])
    }

    fn temperature_c(&self) -> f64 {
        self.world
            .with_courier(|courier| courier.sample().temperature_c)
    }

    fn at_mark(&self) -> bool {
        self.world.is_at_mark()
    }
}

/// What happens to a byte on its way from a converter to its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteFault {
    /// A bit of it changes.
    Changed,
    /// The bus does not get it.
    Lost,
}

/// The parts at the chip's pins.
pub struct Surroundings {
    /// Both converters.
    pub converter: ConverterWire,
    /// Both banks of the chip's flash, which outlive its resets.
    pub banks: [Bank; 2],
    /// The lamp's level.
    pub lamp: bool,
    /// BUSY never rises.
    pub silent: bool,
    /// A reference mark grounds its input: as it was at the last edge of CONVST.
    pub at_mark: bool,
    /// So many of the next conversions have no pulse of BUSY.
    pub lost_pulses: u32,
    /// What happens to the next bytes that a converter sends: which of the two, what, and to how many.
    pub byte_fault: Option<(usize, ByteFault, u32)>,
    /// The same from the first byte of that chip's next frame on.
    pub next_fault: Option<(usize, ByteFault, u32)>,
    convst: Convst,
    reset: Reset,
    clock: Clock,
    beyond: Box<dyn Beyond>,
    busy_until: Ticks,
    selected: [bool; 2],
}

impl Surroundings {
    /// A board in this world. `flash`: bank 2; bank 1 is erased.
    pub fn new(world: World, flash: SharedFlash) -> Self {
        Self::with_banks(world, [SharedFlash::erased(0), flash])
    }

    /// A board in this world with these banks.
    pub fn with_banks(world: World, banks: [SharedFlash; 2]) -> Self {
        let (converter, clock) = (world.converter.clone(), world.clock.clone());
        let line = world.motion.line();
        let beyond = Box::new(Near { world, line });
        Self::joined(converter, clock, beyond, banks.map(Bank::new))
    }

    /// A board whose world is the host's, and whose bank 2 is.
    ///
    /// # Errors
    /// The host's bank is one of another size.
    pub fn of_host(host: Host) -> Result<Self> {
        let clock = Clock::new();
        let inputs = Inputs::new(host.clone());
        let supply = inputs.supply();
        let converter = ConverterWire::new(clock.clone(), inputs);
        let _ = supply.set(converter.input_fault());
        let banks = [
            Bank::new(SharedFlash::erased(0)),
            Bank::of_host(host.clone())?,
        ];
        Ok(Self::joined(converter, clock, Box::new(host), banks))
    }

    fn joined(
        converter: ConverterWire,
        clock: Clock,
        beyond: Box<dyn Beyond>,
        banks: [Bank; 2],
    ) -> Self {
        Self {
            convst: converter.convst(),
            reset: converter.reset(),
            converter,
            clock,
            beyond,
            banks,
            lamp: false,
            silent: false,
            at_mark: false,
            lost_pulses: 0,
            byte_fault: None,
            next_fault: None,
            busy_until: 0,
            selected: [false; 2],
        }
    }

    /// A reset: the chip's pins drive nothing, and every line of the board falls.
    pub fn release(&mut self, now: Ticks) {
        self.convst(false, false, now);
        self.reset(false, now);
        for chip in (0..2)
            .filter(|chip| self.selected[*chip])
            .collect::<Vec<_>>()
        {
            self.select(chip, false, now);
        }
    }

    fn arrive(&self, now: Ticks) {
        self.clock.advance_to_ns(to_ns(now));
    }

    /// An edge of CONVST, by the timer or by software.
    pub fn convst(&mut self, high: bool, by_timer: bool, now: Ticks) {
        self.arrive(now);
        self.beyond.conversion(by_timer);
        set(&mut self.convst, high);
        self.at_mark = self.beyond.at_mark();
        if high && now >= self.busy_until {
            let left = self.lost_pulses.checked_sub(1);
            self.lost_pulses = left.unwrap_or(0);
            self.busy_until = match left {
                Some(_) => now,
                None => self.conversion_end(now),
            };
        }
    }

    /// When chip 0 takes BUSY down again.
    fn conversion_end(&self, now: Ticks) -> Ticks {
        let mut chip = self.converter.with_chip(0, |chip| chip.clone());
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
        if let Some(fault) = self.next_fault.take_if(|(of, ..)| low && *of == chip) {
            self.byte_fault = Some(fault);
        }
        self.selected[chip] = low;
        self.converter.with_chip(chip, |part| match low {
            true => part.select(to_ns(now)),
            false => part.deselect(),
        });
    }

    /// A byte on a converter's bus, and what the bus gets for it; an undriven data line reads as ones.
    pub fn exchange(&mut self, chip: usize, byte: u8) -> Option<u8> {
        let answer = match self.selected[chip] {
            true => self.converter.with_chip(chip, |part| part.exchange(byte)),
            false => 0xFF,
        };
        match self.byte_fault_of(chip) {
            None => Some(answer),
            Some(ByteFault::Changed) => Some(answer ^ 1),
            Some(ByteFault::Lost) => None,
        }
    }

    fn byte_fault_of(&mut self, chip: usize) -> Option<ByteFault> {
        let (of, fault, left) = self.byte_fault.filter(|(of, ..)| *of == chip)?;
        self.byte_fault = (left > 1).then(|| (of, fault, left - 1));
        Some(fault)
    }

    /// The board sends a byte to the motion controller: its start bit is at `now`.
    pub fn send(&mut self, byte: u8, now: Ticks) {
        self.arrive(now);
        self.beyond.send(byte, to_ns(now));
    }

    /// A byte that the motion controller has sent.
    pub fn receive(&mut self, now: Ticks) -> Option<u8> {
        self.arrive(now);
        self.beyond.receive(to_ns(now))
    }

    /// Temperature of the board, degrees Celsius.
    pub fn temperature_c(&self) -> f64 {
        self.beyond.temperature_c()
    }
}

fn set(pin: &mut impl OutputPin<Error = Infallible>, high: bool) {
    let Ok(()) = pin.set_state(high.into());
}
