//! Statics that are made at compile time and given out once: what is too large to be made on the stack.
#![allow(unsafe_code)] // a mutable static, behind a flag

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A value for the first who asks.
pub struct Once<T> {
    value: UnsafeCell<T>,
    taken: AtomicBool,
}

// SAFETY: `take` gives the one reference out once; the flag is atomic.
unsafe impl<T: Send> Sync for Once<T> {}

impl<T> Once<T> {
    /// Not given out yet.
    pub const fn new(value: T) -> Self {
        Self {
            value: UnsafeCell::new(value),
            taken: AtomicBool::new(false),
        }
    }

    /// The value; none on a second call.
    #[allow(clippy::mut_from_ref)] // the flag sees to it that there is one
    pub fn take(&self) -> Option<&mut T> {
        let first = !self.taken.swap(true, Relaxed);
        // SAFETY: only the first caller comes here, and nobody else ever touches the value.
        first.then(|| unsafe { &mut *self.value.get() })
    }
}
