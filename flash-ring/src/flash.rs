//! A flash behind a pointer: each of embedded-storage with these words and pages is one.

use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};

/// What is programmed at once, bytes.
pub const WORD_BYTES: usize = 8;
/// What is erased at once, bytes.
pub const PAGE_BYTES: usize = 2048;

/// A flash of such words and pages, behind a pointer.
pub trait Flash {
    /// Reads.
    ///
    /// # Errors
    /// The flash's.
    fn read(&mut self, place: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind>;
    /// Programs.
    ///
    /// # Errors
    /// The flash's.
    fn write(&mut self, place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind>;
    /// Erases whole pages.
    ///
    /// # Errors
    /// The flash's.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind>;
    /// Its bytes.
    fn capacity(&self) -> usize;
}

impl<F: NorFlash> Flash for F {
    fn read(&mut self, place: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        const {
            assert!(
                F::READ_SIZE == 1 && F::WRITE_SIZE == WORD_BYTES && F::ERASE_SIZE == PAGE_BYTES
            );
        };
        F::read(self, place, bytes).map_err(|error| error.kind())
    }

    fn write(&mut self, place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        F::write(self, place, bytes).map_err(|error| error.kind())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        F::erase(self, from, to).map_err(|error| error.kind())
    }

    fn capacity(&self) -> usize {
        F::capacity(self)
    }
}
