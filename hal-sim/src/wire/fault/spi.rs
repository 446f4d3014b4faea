//! An SPI device with faults.

use super::Switch;
use embedded_hal::spi::{self, ErrorType as SpiErrorType, Operation, SpiDevice};

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
