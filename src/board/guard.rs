//! What lies below the stack: a region that nobody may touch.
//!
//! The stack is the lowest thing in RAM (flip-link), so one that runs over overwrites nothing. Whether the bus faults below RAM
//! is the chip's choice; the memory protection unit makes sure of it, at the first access, on every board alike. The fault
//! is taken by [`fault`](super::fault), which the unit leaves alone (HFNMIENA is zero).
#![allow(unsafe_code)] // a register of the processor's

use super::RAM_START;

/// Larger than any one frame of the stack, so that none reaches over it; below RAM the g474 has nothing as near.
const BYTES: u32 = 16 << 10;

/// Sets the region up. To be called once, first.
pub fn start() {
    const { assert!(BYTES.is_power_of_two() && RAM_START % BYTES == 0) };
    /// Region number given with the address (VALID).
    const VALID: u32 = 1 << 4;
    /// No instructions, access by nobody (AP 0), a size of 2^(SIZE + 1), on.
    const ATTRIBUTES: u32 = 1 << 28 | (BYTES.ilog2() - 1) << 1 | 1;
    /// On, everything else as without (PRIVDEFENA).
    const CONTROL: u32 = 1 << 2 | 1;
    // SAFETY: forbids what nothing owns; barriers follow, as the architecture wants before the next access counts.
    unsafe {
        let unit = &*cortex_m::peripheral::MPU::PTR;
        unit.rbar.write((RAM_START - BYTES) | VALID);
        unit.rasr.write(ATTRIBUTES);
        unit.ctrl.write(CONTROL);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
