//! Two converter chips, their bus and their common pins, as embedded-hal parts.
//!
//! [`ConverterWire`] hands out one SPI device a chip, CONVST, RESET and BUSY; the courier around it is an [`AnalogInputs`].
//! Every transfer and every look at a pin takes virtual time.

use super::ad7606c::{Ad7606c, CHANNELS};
use super::clock::Clock;
use super::fault::{self, InputFault, Switch};
use embedded_hal::digital::{ErrorType as PinErrorType, InputPin, OutputPin};
use embedded_hal::spi::{ErrorType as SpiErrorType, Operation, SpiDevice};
use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

/// What stands at the converters' inputs.
pub trait AnalogInputs {
    /// Counts at ±5 V full scale, `[chip][channel]`, at the rising edge of CONVST.
    fn sample(&mut self, now_ns: u64) -> [[i16; CHANNELS]; 2];
}

impl<F: FnMut(u64) -> [[i16; CHANNELS]; 2]> AnalogInputs for F {
    fn sample(&mut self, now_ns: u64) -> [[i16; CHANNELS]; 2] {
        self(now_ns)
    }
}

/// SPI clock of the board: 170 MHz / 8.
const SCLK_HZ: u64 = 21_250_000;
/// One look at a pin, or one write to it: some eight cycles at 170 MHz.
const PIN_NS: u64 = 50;
/// Chip select's set-up and hold around a transfer.
const SELECT_NS: u64 = 50;

struct Wire {
    clock: Clock,
    chips: [Ad7606c; 2],
    inputs: Box<dyn AnalogInputs>,
    input_fault: Switch<InputFault>,
    last_inputs: [[i16; CHANNELS]; 2],
    convst: bool,
    reset: bool,
    conversions: u64,
}

impl Wire {
    fn take_inputs(&mut self, now_ns: u64) -> Option<[[i16; CHANNELS]; 2]> {
        let fresh = self.inputs.sample(now_ns);
        self.conversions += 1;
        fault::spoil(&self.input_fault, fresh, &mut self.last_inputs)
    }
}

/// The converters' side of the board. Clones are the same wire.
#[derive(Clone)]
pub struct ConverterWire(Rc<RefCell<Wire>>);

impl ConverterWire {
    /// Two chips after power-up, with the courier at their inputs.
    pub fn new(clock: Clock, inputs: impl AnalogInputs + 'static) -> Self {
        Self(Rc::new(RefCell::new(Wire {
            clock,
            chips: [Ad7606c::default(), Ad7606c::default()],
            inputs: Box::new(inputs),
            input_fault: Switch::new(0),
            last_inputs: [[0; CHANNELS]; 2],
            convst: false,
            reset: false,
            conversions: 0,
        })))
    }

    /// SPI device of chip 0 or 1.
    ///
    /// # Panics
    /// If there is no such chip.
    pub fn spi(&self, chip: usize) -> Spi {
        assert!(chip < 2, "chip {chip}: there are 0 and 1");
        Spi {
            wire: self.0.clone(),
            chip,
        }
    }

    /// The common CONVST line.
    pub fn convst(&self) -> Convst {
        Convst(self.0.clone())
    }

    /// The common RESET line.
    pub fn reset(&self) -> Reset {
        Reset(self.0.clone())
    }

    /// Chip 0's BUSY line.
    pub fn busy(&self) -> Busy {
        Busy(self.0.clone())
    }

    /// Switch of the faults before the converters.
    pub fn input_fault(&self) -> Switch<InputFault> {
        self.0.borrow().input_fault.clone()
    }

    /// Rising edges of CONVST so far.
    pub fn conversions(&self) -> u64 {
        self.0.borrow().conversions
    }

    /// A rising edge of CONVST for converters that are elsewhere: what stands at their inputs at this instant, faults included; none if
    /// they have no supply. The chips of this wire take no part.
    pub fn inputs_at(&self, now_ns: u64) -> Option<[[i16; CHANNELS]; 2]> {
        self.0.borrow_mut().take_inputs(now_ns)
    }

    /// Reaches into a chip: to give it another identity, or to make it lose its supply.
    pub fn with_chip<R>(&self, chip: usize, f: impl FnOnce(&mut Ad7606c) -> R) -> R {
        f(&mut self.0.borrow_mut().chips[chip])
    }
}

/// One chip's SPI device.
pub struct Spi {
    wire: Rc<RefCell<Wire>>,
    chip: usize,
}

impl SpiErrorType for Spi {
    type Error = Infallible;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let wire = &mut *self.wire.borrow_mut();
        let chip = &mut wire.chips[self.chip];
        wire.clock.advance_ns(SELECT_NS);
        chip.select(wire.clock.now_ns());
        for operation in operations {
            let bytes = run(chip, operation);
            let wait_ns = if let Operation::DelayNs(ns) = operation {
                u64::from(*ns)
            } else {
                0
            };
            wire.clock
                .advance_ns(wait_ns + bytes as u64 * 8 * 1_000_000_000 / SCLK_HZ);
        }
        chip.deselect();
        Ok(())
    }
}

/// Clocks one operation's bytes; returns how many.
fn run(chip: &mut Ad7606c, operation: &mut Operation<'_, u8>) -> usize {
    match operation {
        Operation::Read(read) => {
            read.iter_mut().for_each(|byte| *byte = chip.exchange(0));
            read.len()
        }
        Operation::Write(write) => {
            for &byte in write.iter() {
                chip.exchange(byte);
            }
            write.len()
        }
        Operation::Transfer(read, write) => {
            let clocks = read.len().max(write.len());
            for index in 0..clocks {
                let out = chip.exchange(write.get(index).copied().unwrap_or(0));
                if let Some(slot) = read.get_mut(index) {
                    *slot = out;
                }
            }
            clocks
        }
        Operation::TransferInPlace(bytes) => {
            bytes
                .iter_mut()
                .for_each(|byte| *byte = chip.exchange(*byte));
            bytes.len()
        }
        Operation::DelayNs(_) => 0,
    }
}

/// CONVST.
pub struct Convst(Rc<RefCell<Wire>>);

impl PinErrorType for Convst {
    type Error = Infallible;
}

impl OutputPin for Convst {
    fn set_high(&mut self) -> Result<(), Infallible> {
        let wire = &mut *self.0.borrow_mut();
        wire.clock.advance_ns(PIN_NS);
        if !wire.convst {
            let now_ns = wire.clock.now_ns();
            if let Some(inputs) = wire.take_inputs(now_ns) {
                let chips = wire.chips.iter_mut().zip(&inputs);
                chips.for_each(|(chip, inputs)| chip.convst(now_ns, inputs));
            }
        }
        wire.convst = true;
        Ok(())
    }

    fn set_low(&mut self) -> Result<(), Infallible> {
        let wire = &mut *self.0.borrow_mut();
        wire.clock.advance_ns(PIN_NS);
        wire.convst = false;
        Ok(())
    }
}

/// RESET.
pub struct Reset(Rc<RefCell<Wire>>);

impl PinErrorType for Reset {
    type Error = Infallible;
}

impl OutputPin for Reset {
    fn set_high(&mut self) -> Result<(), Infallible> {
        let wire = &mut *self.0.borrow_mut();
        wire.clock.advance_ns(PIN_NS);
        if !wire.reset {
            wire.chips.iter_mut().for_each(Ad7606c::reset);
        }
        wire.reset = true;
        Ok(())
    }

    fn set_low(&mut self) -> Result<(), Infallible> {
        let wire = &mut *self.0.borrow_mut();
        wire.clock.advance_ns(PIN_NS);
        wire.reset = false;
        Ok(())
    }
}

/// BUSY.
pub struct Busy(Rc<RefCell<Wire>>);

impl PinErrorType for Busy {
    type Error = Infallible;
}

impl InputPin for Busy {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let wire = &mut *self.0.borrow_mut();
        wire.clock.advance_ns(PIN_NS);
        Ok(wire.chips[0].busy(wire.clock.now_ns()))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
