//! Critical sections that the sampling interrupt is not part of: they mask every priority below it and the look for a hang.
//!
//! Nothing that the sampling interrupt does needs one (its queues are lock-free), so nothing may delay it: neither a log
//! line nor a serial port's register. `cargo xtask firmware` follows its calls in the image, and those of the look: neither masks
//! interrupts or enters a critical section.
#![allow(unsafe_code)] // the trait of the implementation is unsafe

use super::interrupt::BELOW_SAMPLING;
use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
use cortex_m::register::{basepri, basepri_max};
use critical_section::{Impl, RawRestoreState, set_impl};

struct BelowSampling;
set_impl!(BelowSampling);

// SAFETY: one processor; every interrupt but the sampling one and the look for a hang has a priority that the mask holds back, and
// those two neither enter critical sections nor touch what they guard.
unsafe impl Impl for BelowSampling {
    unsafe fn acquire() -> RawRestoreState {
        let before = basepri::read();
        basepri_max::write(BELOW_SAMPLING);
        compiler_fence(SeqCst);
        before
    }

    unsafe fn release(before: RawRestoreState) {
        compiler_fence(SeqCst);
        // SAFETY: the value that was there.
        unsafe { basepri::write(before) };
    }
}
