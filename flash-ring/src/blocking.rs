//! A flash as sequential-storage wants it: nothing of it ever waits, so each operation ends at the first poll.

use crate::flash::{Flash, PAGE_BYTES, WORD_BYTES};
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};
use embedded_storage_async::nor_flash as waiting;

/// The result of a future that never waits; none if it did, which would be a mistake in this file.
pub fn now<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Some(result),
        Poll::Pending => None,
    }
}

/// A flash for the time of an operation.
pub struct Blocking<'f> {
    flash: &'f mut dyn Flash,
    /// Where a write was not taken, or an erase.
    failed_at: &'f mut Option<u32>,
}

/// What the flash said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed(NorFlashErrorKind);

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl<'f> Blocking<'f> {
    /// `failed_at` gets the place of an operation that the flash refused.
    pub fn new(flash: &'f mut dyn Flash, failed_at: &'f mut Option<u32>) -> Self {
        Self { flash, failed_at }
    }

    fn noted(&mut self, place: u32, result: Result<(), NorFlashErrorKind>) -> Result<(), Failed> {
        result.map_err(|kind| {
            *self.failed_at = Some(place);
            Failed(kind)
        })
    }
}

impl waiting::ErrorType for Blocking<'_> {
    type Error = Failed;
}

impl waiting::ReadNorFlash for Blocking<'_> {
    const READ_SIZE: usize = 1;

    /// What cannot be read, as a double word that was torn, reads as zeros: check values are wrong then, and it is not free.
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        if self.flash.read(offset, bytes).is_err() {
            bytes.fill(0);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl waiting::NorFlash for Blocking<'_> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let erased = self.flash.erase(from, to);
        self.noted(from, erased)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        let written = self.flash.write(offset, bytes);
        self.noted(offset, written)
    }
}
