//! A flash with faults.

use super::Switch;
use crate::wire::flash::FlashError;
use embedded_storage::nor_flash::{self, NorFlash, ReadNorFlash};

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
