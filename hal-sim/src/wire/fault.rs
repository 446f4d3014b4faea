//! What can go wrong with any part, as wrappers around it: the part itself stays as it is.
//!
//! A [`Switch`] says which fault acts and when; its clones are the same switch, so that a test turns a fault on and off while the
//! wrapped part is in the driver's hands. Everything is seeded: a run repeats exactly.

use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use embedded_hal::digital::{ErrorType as PinErrorType, InputPin, OutputPin};
use embedded_hal::spi::{self, ErrorType as SpiErrorType, Operation, SpiDevice};
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::{self, NorFlash, ReadNorFlash};
use std::cell::RefCell;
use std::rc::Rc;

use super::flash::FlashError;

/// When a fault acts, counted in the part's own operations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// At every operation.
    Always,
    /// At the next operations, so many.
    Next(u64),
    /// At each operation with this probability.
    Sometimes(f64),
}

struct State<F> {
    fault: Option<(F, When)>,
    rng: ChaCha8Rng,
    struck: u64,
}

/// Turns one kind of fault on and off.
pub struct Switch<F>(Rc<RefCell<State<F>>>);

impl<F> Clone for Switch<F> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<F: Copy> Switch<F> {
    /// Off.
    pub fn new(seed: u64) -> Self {
        Self(Rc::new(RefCell::new(State {
            fault: None,
            rng: ChaCha8Rng::seed_from_u64(seed),
            struck: 0,
        })))
    }

    /// From now on this fault acts.
    pub fn set(&self, fault: F, when: When) {
        self.0.borrow_mut().fault = Some((fault, when));
    }

    /// From now on all is well.
    pub fn clear(&self) {
        self.0.borrow_mut().fault = None;
    }

    /// Operations that the fault has spoilt so far: a test whose fault never struck has shown nothing.
    pub fn struck(&self) -> u64 {
        self.0.borrow().struck
    }

    /// The fault, if it acts on the operation that begins now.
    fn strike(&self) -> Option<F> {
        let state = &mut *self.0.borrow_mut();
        let (fault, when) = state.fault.as_mut()?;
        let acts = match when {
            When::Always => true,
            When::Next(left) => {
                let acts = *left > 0;
                *left = left.saturating_sub(1);
                acts
            }
            When::Sometimes(probability) => uniform(&mut state.rng, 0.0, 1.0) < *probability,
        };
        state.struck += u64::from(acts);
        acts.then_some(*fault)
    }

    fn uniform(&self, high: f64) -> f64 {
        uniform(&mut self.0.borrow_mut().rng, 0.0, high)
    }

    /// Each bit of each byte flips with this probability.
    fn flip(&self, bytes: &mut [u8], probability: f64) {
        for byte in bytes {
            for bit in 0..8 {
                if self.uniform(1.0) < probability {
                    *byte ^= 1 << bit;
                }
            }
        }
    }
}

/// Faults of an SPI device; an operation is one chip-select frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpiFault {
    /// What is read stays at this level: 0x00 or 0xFF.
    Stuck(u8),
    /// Each bit read flips with this probability.
    Flips(f64),
    /// What was read last is read again.
    Frozen,
    /// The bus reports an error.
    Bus,
}

/// An SPI device with faults. Its errors are generic kinds.
pub struct FaultySpi<S> {
    part: S,
    switch: Switch<SpiFault>,
    last: Vec<u8>,
}

impl<S> FaultySpi<S> {
    /// Wraps a device.
    pub fn new(part: S, switch: Switch<SpiFault>) -> Self {
        Self {
            part,
            switch,
            last: Vec::new(),
        }
    }

    fn spoil(&mut self, fault: SpiFault, read: &mut [u8]) {
        match fault {
            SpiFault::Stuck(level) => read.fill(level),
            SpiFault::Flips(probability) => self.switch.flip(read, probability),
            SpiFault::Frozen => read
                .iter_mut()
                .zip(&self.last)
                .for_each(|(byte, last)| *byte = *last),
            SpiFault::Bus => {}
        }
    }
}

impl<S> SpiErrorType for FaultySpi<S> {
    type Error = spi::ErrorKind;
}

impl<S: SpiDevice> SpiDevice for FaultySpi<S> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        let fault = self.switch.strike();
        if fault == Some(SpiFault::Bus) {
            return Err(spi::ErrorKind::Other);
        }
        self.part
            .transaction(operations)
            .map_err(|error| spi::Error::kind(&error))?;
        for operation in operations {
            let (Operation::Read(read)
            | Operation::Transfer(read, _)
            | Operation::TransferInPlace(read)) = operation
            else {
                continue;
            };
            match fault {
                Some(fault) => self.spoil(fault, read),
                None => self.last = read.to_vec(),
            }
        }
        Ok(())
    }
}

/// Faults of a pin: the line is stuck at this level, whatever is on the other side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(pub bool);

/// A pin with faults.
pub struct FaultyPin<P> {
    part: P,
    switch: Switch<Level>,
}

impl<P> FaultyPin<P> {
    /// Wraps a pin.
    pub fn new(part: P, switch: Switch<Level>) -> Self {
        Self { part, switch }
    }
}

impl<P: PinErrorType> PinErrorType for FaultyPin<P> {
    type Error = P::Error;
}

impl<P: InputPin> InputPin for FaultyPin<P> {
    fn is_high(&mut self) -> Result<bool, P::Error> {
        // Read in any case: a look at a pin takes time.
        let high = self.part.is_high()?;
        Ok(self.switch.strike().map_or(high, |level| level.0))
    }

    fn is_low(&mut self) -> Result<bool, P::Error> {
        self.is_high().map(|high| !high)
    }
}

impl<P: OutputPin> OutputPin for FaultyPin<P> {
    fn set_high(&mut self) -> Result<(), P::Error> {
        match self.switch.strike() {
            Some(Level(false)) => self.part.set_low(),
            _ => self.part.set_high(),
        }
    }

    fn set_low(&mut self) -> Result<(), P::Error> {
        match self.switch.strike() {
            Some(Level(true)) => self.part.set_high(),
            _ => self.part.set_low(),
        }
    }
}

/// Faults of a serial line; an operation is one byte in either direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SerialFault {
    /// Each bit flips with this probability.
    Flips(f64),
    /// The byte is lost.
    Dropped,
    /// The byte becomes another one.
    Noise,
    /// The line reports an error.
    Line,
}

/// A serial line with faults.
pub struct FaultySerial<S> {
    part: S,
    switch: Switch<SerialFault>,
}

impl<S> FaultySerial<S> {
    /// Wraps a line.
    pub fn new(part: S, switch: Switch<SerialFault>) -> Self {
        Self { part, switch }
    }

    /// The byte as it passes, if it does.
    fn pass(&self, byte: u8) -> Result<Option<u8>, ErrorKind> {
        Ok(match self.switch.strike() {
            None => Some(byte),
            Some(SerialFault::Flips(probability)) => {
                let mut bytes = [byte];
                self.switch.flip(&mut bytes, probability);
                Some(bytes[0])
            }
            Some(SerialFault::Dropped) => None,
            Some(SerialFault::Noise) => Some(self.switch.uniform(256.0) as u8),
            Some(SerialFault::Line) => return Err(ErrorKind::Other),
        })
    }
}

impl<S> ErrorType for FaultySerial<S> {
    type Error = ErrorKind;
}

impl<S: ReadReady> ReadReady for FaultySerial<S> {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        self.part
            .read_ready()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}

impl<S: Read> Read for FaultySerial<S> {
    /// May return 0 where the only byte was lost.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        let read = self
            .part
            .read(buffer)
            .map_err(|error| embedded_io::Error::kind(&error))?;
        let mut kept = 0;
        for index in 0..read {
            if let Some(byte) = self.pass(buffer[index])? {
                buffer[kept] = byte;
                kept += 1;
            }
        }
        Ok(kept)
    }
}

impl<S: WriteReady> WriteReady for FaultySerial<S> {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        self.part
            .write_ready()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}

impl<S: Write> Write for FaultySerial<S> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let Some(first) = bytes.first() else {
            return Ok(0);
        };
        if let Some(byte) = self.pass(*first)? {
            self.part
                .write(&[byte])
                .map_err(|error| embedded_io::Error::kind(&error))?;
        }
        Ok(1)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        self.part
            .flush()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}

/// Faults of a flash; an operation is one erase, write or read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlashFault {
    /// Erasing reports an error and erases nothing.
    EraseFails,
    /// Erasing reports success and erases nothing.
    EraseLies,
    /// Writing reports an error after so many bytes, rounded down to whole words.
    WriteFails(usize),
    /// Writing reports success and writes nothing.
    WriteLies,
    /// Each bit read flips with this probability.
    ReadFlips(f64),
    /// Reading reports an error.
    ReadFails,
}

/// A flash with faults.
pub struct FaultyFlash<F> {
    part: F,
    switch: Switch<FlashFault>,
}

impl<F> FaultyFlash<F> {
    /// Wraps a flash.
    pub fn new(part: F, switch: Switch<FlashFault>) -> Self {
        Self { part, switch }
    }
}

fn flash_error(error: impl nor_flash::NorFlashError) -> FlashError {
    FlashError::Arguments(error.kind())
}

impl<F> nor_flash::ErrorType for FaultyFlash<F> {
    type Error = FlashError;
}

impl<F: ReadNorFlash> ReadNorFlash for FaultyFlash<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.part.read(offset, bytes).map_err(flash_error)?;
        match self.switch.strike() {
            Some(FlashFault::ReadFails) => return Err(FlashError::Failed),
            Some(FlashFault::ReadFlips(probability)) => self.switch.flip(bytes, probability),
            _ => {}
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.part.capacity()
    }
}

impl<F: NorFlash> NorFlash for FaultyFlash<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        match self.switch.strike() {
            Some(FlashFault::EraseFails) => Err(FlashError::Failed),
            Some(FlashFault::EraseLies) => Ok(()),
            _ => self.part.erase(from, to).map_err(flash_error),
        }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        match self.switch.strike() {
            Some(FlashFault::WriteFails(written)) => {
                let whole = written.min(bytes.len()) / F::WRITE_SIZE * F::WRITE_SIZE;
                self.part
                    .write(offset, &bytes[..whole])
                    .map_err(flash_error)?;
                Err(FlashError::Failed)
            }
            Some(FlashFault::WriteLies) => Ok(()),
            _ => self.part.write(offset, bytes).map_err(flash_error),
        }
    }
}
