//! The Cortex-M4F's square root instruction.
//!
//! `libm::sqrtf` is software on this target and `core::f32::math::sqrt` is unstable, so one instruction is written out.

/// Square root, correctly rounded; NaN for x < 0. 17 cycles.
#[inline(always)]
#[allow(unsafe_code)] // inline assembly is the only stable way to VSQRT on this target
pub fn sqrt(x: f32) -> f32 {
    let mut bits = x.to_bits();
    // SAFETY: touches the named registers only; every image runs with the floating-point unit on (hard-float target).
    unsafe {
        core::arch::asm!("vmov s0, {0}", "vsqrt.f32 s0, s0", "vmov {0}, s0", inout(reg) bits, out("s0") _,
            options(pure, nomem, nostack, preserves_flags));
    }
    f32::from_bits(bits)
}
