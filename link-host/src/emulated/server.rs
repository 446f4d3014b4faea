//! Answers the emulated board's questions with the simulated parts.

use anyhow::Result;
use courier_sensor::emulation::{
    BACKGROUND, DATA_BYTES, FAILED, HEADER_BYTES, HUNG, INTERRUPT, MAILBOX_BASE, MAILBOX_STRIDE,
    Operation, POWER_LOST, Pin, STACK_SPENT, TICK_HZ, Word,
};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice as _;
use embedded_io::{Read, ReadReady, Write};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hal_sim::board::SharedFlash;
use hal_sim::wire::converter::{Busy, Convst, Reset, Spi};
use hal_sim::wire::fault::{FaultySpi, SpiFault, Switch};
use hal_sim::wire::flash::{FlashError, PAGE_BYTES};
use hal_sim::wire::motion::Line;
use hal_sim::world::World;

use std::cell::Cell;
use std::rc::Rc;

use super::ahead::Ahead;
use super::shared::SharedRam;
use crate::memory::TargetMemory;

/// Nanoseconds of a tick.
const TICK_NS: u64 = 1_000_000_000 / TICK_HZ as u64;
/// Looks at BUSY after which a conversion is given up: 80 us.
const BUSY_LOOKS: u32 = 4096;

/// The parts at the board's pins, and the flash inside it.
pub struct Parts {
    /// Everything around the processor.
    pub world: World,
    /// The flash bank of the slots.
    pub flash: SharedFlash,
    /// The status LED's level.
    pub led: bool,
    /// Faults on the bus, a switch each chip.
    pub bus_faults: [Switch<SpiFault>; 2],
    /// Questions of this operation are never answered: who asks hangs. Clones are the same.
    pub hang: Rc<Cell<Option<Operation>>>,
    /// At a question of this operation the board's stack runs over, once. Clones are the same.
    pub stack_spent: Rc<Cell<Option<Operation>>>,
    chips: [FaultySpi<Spi>; 2],
    ahead: Ahead,
    /// No conversion since the start yet.
    fresh: bool,
    arrived: [Option<u32>; 2],
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
        let bus_faults = [Switch::new(0), Switch::new(1)];
        let chips =
            [0, 1].map(|chip: usize| FaultySpi::new(wire.spi(chip), bus_faults[chip].clone()));
        let (convst, reset, busy) = (wire.convst(), wire.reset(), wire.busy());
        let line = world.motion.line();
        Self {
            bus_faults,
            hang: Rc::default(),
            stack_spent: Rc::default(),
            chips,
            ahead: Ahead::default(),
            fresh: true,
            arrived: [None; 2],
            convst,
            reset,
            busy,
            line,
            world,
            flash,
            led: false,
            last_ticks: 0,
            board_ns: 0,
        }
    }

    /// Takes note of the open questions and brings the world's time to theirs; returns whether the image has just started.
    ///
    /// # Errors
    /// The mailboxes cannot be reached.
    pub fn arrive(&mut self, ram: &mut SharedRam) -> Result<bool> {
        let mut started = false;
        for index in [INTERRUPT, BACKGROUND] {
            let word = |word: Word| word_of(index, word);
            let sequence = ram.read_word(word(Word::Sequence))?;
            if sequence == ram.read_word(word(Word::Done))? || self.arrived[index] == Some(sequence)
            {
                continue;
            }
            self.arrived[index] = Some(sequence);
            let operation = Operation::from_word(ram.read_word(word(Word::Operation))?);
            self.pass_time(operation, ram.read_word(word(Word::Ticks))?);
            started |= operation == Some(Operation::Boot);
        }
        Ok(started)
    }

    /// Answers every open question of both mailboxes.
    ///
    /// # Errors
    /// The mailboxes cannot be reached.
    pub fn answer(&mut self, ram: &mut SharedRam) -> Result<()> {
        for index in [INTERRUPT, BACKGROUND] {
            let word = |word: Word| word_of(index, word);
            let sequence = ram.read_word(word(Word::Sequence))?;
            if sequence == ram.read_word(word(Word::Done))? {
                continue;
            }
            let operation = Operation::from_word(ram.read_word(word(Word::Operation))?);
            let length = (ram.read_word(word(Word::Length))? as usize).min(DATA_BYTES);
            let argument = ram.read_word(word(Word::Argument))?;
            let mut data = [0; DATA_BYTES];
            let place = word(Word::Sequence) + HEADER_BYTES;
            ram.read(place, &mut data[..length])?;
            let answer = match operation {
                Some(operation) if self.hang.get() == Some(operation) => HUNG,
                Some(operation) if self.stack_spent.get() == Some(operation) => {
                    self.stack_spent.set(None);
                    STACK_SPENT
                }
                Some(operation) => self.carry_out(operation, argument, &mut data[..length], ram)?,
                None => FAILED,
            };
            ram.write(place, &data[..length])?;
            ram.write_word(word(Word::Answer), answer)?;
            ram.write_word(word(Word::Done), sequence)?;
        }
        Ok(())
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
            let passed = ticks.wrapping_sub(self.last_ticks);
            // The background's stamp is older than that of the interrupt which came between stamp and bell.
            if passed > u32::MAX / 2 {
                return;
            }
            passed
        };
        self.last_ticks = ticks;
        // What the parts themselves took is already past, so the clock is brought up to the board's, not added to.
        self.board_ns += u64::from(passed) * TICK_NS;
        self.world.clock.advance_to_ns(self.board_ns);
    }

    fn carry_out(
        &mut self,
        operation: Operation,
        argument: u32,
        data: &mut [u8],
        ram: &mut SharedRam,
    ) -> Result<u32> {
        match operation {
            Operation::Boot => self.boot(data, ram)?,
            Operation::Convert => return self.conversion(argument, ram),
            Operation::Spi => return self.transfer(argument as usize, data, ram),
            Operation::SetPin => {
                if argument >> 1 != Pin::Led as u32 {
                    self.ahead.take_back(&self.world, ram)?;
                }
                return Ok(self.set_pin(argument).unwrap_or(FAILED));
            }
            Operation::GetPin if argument == Pin::Busy as u32 => {
                return Ok(u32::from(self.busy.is_high() == Ok(true)));
            }
            Operation::GetPin => return Ok(FAILED),
            Operation::SerialWrite => return Ok(count(self.line.write(data))),
            Operation::SerialRead if self.line.read_ready() == Ok(true) => {
                return Ok(count(self.line.read(data)));
            }
            Operation::SerialRead => {}
            Operation::FlashRead => return Ok(flash(self.flash.read(argument, data))),
            Operation::FlashErase => {
                let end = argument + PAGE_BYTES as u32;
                return Ok(flash(self.flash.erase(argument, end)));
            }
            Operation::FlashWrite => return Ok(flash(self.flash.write(argument, data))),
            Operation::Temperature => {
                let sample = self.world.with_courier(|courier| *courier.sample());
                let thousandths = (sample.temperature_c * 1000.0) as i32 as u32;
                return Ok(thousandths.wrapping_add(1_000_000));
            }
        }
        Ok(0)
    }

    /// The supply is there again, nothing that was answered ahead holds, and the image is told which board it runs on.
    fn boot(&mut self, number: &mut [u8], ram: &mut SharedRam) -> Result<()> {
        let own = self.world.number.0.iter();
        number
            .iter_mut()
            .zip(own)
            .for_each(|(place, byte)| *place = *byte);
        self.flash.0.borrow_mut().power_up();
        self.fresh = true;
        self.ahead.take_back(&self.world, ram)
    }

    /// One sampling instant as asked, and some more ahead.
    fn conversion(&mut self, period: u32, ram: &mut SharedRam) -> Result<u32> {
        if core::mem::take(&mut self.fresh) {
            self.world.begin_sampling();
        }
        let further = self.ahead.begin(ram)?;
        let answer = self.convert();
        if further == 0 || answer & 1 == 0 {
            return Ok(answer);
        }
        let (at_ns, stamp) = (self.board_ns, self.last_ticks);
        // The instant that was asked for leads the row: its transfers are given as well.
        let mut conversion = answer;
        for index in 0..further {
            let ticks = index * period;
            if index > 0 {
                let instant_ns = at_ns + u64::from(ticks) * TICK_NS;
                self.world.clock.advance_to_ns(instant_ns);
                conversion = self.convert();
            }
            let before =
                [0, 1].map(|chip| self.world.converter.with_chip(chip, |chip| chip.clone()));
            let mut transfers = [0, 1].map(|chip| self.ahead.question(chip).to_vec());
            if conversion & 1 == 0 || !self.transfers(&mut transfers) {
                // Not as usual: what happens at this instant is seen when it comes.
                for (chip, before) in before.into_iter().enumerate() {
                    self.world.converter.with_chip(chip, |now| *now = before);
                }
                break;
            }
            let stamp = stamp.wrapping_add(ticks);
            self.ahead.give(stamp, conversion, transfers, before, ram)?;
        }
        self.ahead.take_first(ram)?;
        Ok(answer)
    }

    /// Both chips' transfers; false if the bus failed.
    fn transfers(&mut self, both: &mut [Vec<u8>; 2]) -> bool {
        let mut chips = self.chips.iter_mut().zip(both);
        chips.all(|(chip, bytes)| chip.transfer_in_place(bytes).is_ok())
    }

    fn transfer(&mut self, index: usize, data: &mut [u8], ram: &mut SharedRam) -> Result<u32> {
        self.ahead.learn(index, data, &self.world, ram)?;
        let chip = self.chips.get_mut(index);
        let done = chip.map(|chip| chip.transfer_in_place(data));
        Ok(if matches!(done, Some(Ok(()))) {
            0
        } else {
            FAILED
        })
    }

    /// What the timer's pulse and BUSY do on the real board, an edge each: bit 0 if it rose and fell, bit 1 if the serial
    /// line has bytes.
    fn convert(&mut self) -> u32 {
        let _ = self.convst.set_high();
        let rose = self.busy.is_high() == Ok(true);
        let _ = self.convst.set_low();
        let fell = rose && (0..BUSY_LOOKS).any(|_| self.busy.is_low() == Ok(true));
        let bytes = u32::from(self.line.read_ready() == Ok(true));
        u32::from(fell) | bytes << 1 | u32::from(self.world.is_at_mark()) << 2
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

/// Address of a word of mailbox `index`.
fn word_of(index: usize, word: Word) -> u32 {
    MAILBOX_BASE + index as u32 * MAILBOX_STRIDE + 4 * word as u32
}

fn count<E>(bytes: Result<usize, E>) -> u32 {
    bytes.map_or(FAILED, |count| count as u32)
}

/// The flash works from the board's own supply: when it has none, nothing has.
fn flash(result: Result<(), FlashError>) -> u32 {
    match result {
        Ok(()) => 0,
        Err(FlashError::Off) => POWER_LOST,
        Err(_) => FAILED,
    }
}

fn set(pin: &mut impl OutputPin, level: bool) {
    let _ = if level { pin.set_high() } else { pin.set_low() };
}
