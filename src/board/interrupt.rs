//! Priorities, and what an interrupt owns.
#![allow(unsafe_code)] // sharing with an interrupt that nothing else is allowed to run in

use core::cell::UnsafeCell;
use core::sync::atomic::{Ordering::SeqCst, compiler_fence};

/// Priority of what only ends in a restart: the highest there is.
#[cfg(feature = "g474")]
pub const ABOVE_SAMPLING: u8 = 0x00;
/// Priority of the sampling interrupt. The processor has the upper four bits of it.
pub const SAMPLING: u8 = 0x10;
/// Priority of the look at the main loop ([`super::hang`]): nothing holds it back but the sampling interrupt.
pub const LOOK: u8 = 0x40;
/// Priority of every other one but the intake's, and the mask that holds both back.
pub const BELOW_SAMPLING: u8 = 0x80;
/// Priority of the intake of frames: the lowest of those in use, since it may run for longer than a byte takes on the serial line.
pub const INTAKE: u8 = 0xC0;

/// Something that one interrupt owns from the moment it is put there.
pub struct Owned<T>(UnsafeCell<Option<T>>);

// SAFETY: see `put` and `get`.
unsafe impl<T: Send> Sync for Owned<T> {}

impl<T> Owned<T> {
    /// Nothing there yet.
    pub const fn empty() -> Self {
        Self(UnsafeCell::new(None))
    }

    /// Gives it away.
    ///
    /// # Safety
    /// The interrupt that owns it is not enabled yet.
    pub unsafe fn put(&self, value: T) {
        // SAFETY: the caller's promise: nobody else looks.
        unsafe { *self.0.get() = Some(value) };
        // Before whatever enables the interrupt: that is a volatile write, which alone would keep no other in its place.
        compiler_fence(SeqCst);
    }

    /// The interrupt's access; none before [`Owned::put`].
    ///
    /// # Safety
    /// Called by the one interrupt that owns it, once at a time.
    #[inline(always)]
    pub unsafe fn get(&self) -> Option<&mut T> {
        // SAFETY: the caller's promise: an interrupt does not interrupt itself.
        unsafe { (*self.0.get()).as_mut() }
    }
}
