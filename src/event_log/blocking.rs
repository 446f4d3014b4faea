//! A flash of embedded-storage as sequential-storage wants it: nothing of it ever waits, so each operation ends at the first poll.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use embedded_storage_async::nor_flash as waiting;

/// The result of a future that never waits; none if it did, which would be a mistake in this file.
pub fn now<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Some(result),
        Poll::Pending => None,
    }
}

/// A flash for the time of an operation.
#[derive(Debug)]
pub struct Blocking<'f, F> {
    flash: &'f mut F,
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

impl<'f, F: NorFlash> Blocking<'f, F> {
    /// `failed_at` gets the place of an operation that the flash refused.
    pub fn new(flash: &'f mut F, failed_at: &'f mut Option<u32>) -> Self {
        Self { flash, failed_at }
    }

    fn noted<T>(&mut self, place: u32, result: Result<T, F::Error>) -> Result<T, Failed> {
        result.map_err(|error| {
            *self.failed_at = Some(place);
            Failed(error.kind())
        })
    }
}

impl<F: NorFlash> waiting::ErrorType for Blocking<'_, F> {
    type Error = Failed;
}

impl<F: NorFlash> waiting::ReadNorFlash for Blocking<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

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

impl<F: NorFlash> waiting::NorFlash for Blocking<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let erased = self.flash.erase(from, to);
        self.noted(from, erased)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        let written = self.flash.write(offset, bytes);
        self.noted(offset, written)
    }
}
