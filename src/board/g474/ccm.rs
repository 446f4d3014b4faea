//! The CCM RAM: the sampling interrupts' code, of which no instruction waits for the flash there, the queue of frames and
//! their intake, and the state of an update. `memory.x` says what else.
#![allow(unsafe_code)] // memory that the linker places

unsafe extern "C" {
    static mut __ccm_start: u32;
    static __ccm_end: u32;
    static __ccm_stored: u32;
    static mut __ccm_zero_start: u32;
    static __ccm_zero_end: u32;
}

/// Copies the code there from flash, and clears the rest. To be called first of all, before anything there is called.
pub fn load() {
    let (mut to, mut from) = (&raw mut __ccm_start, &raw const __ccm_stored);
    let end = &raw const __ccm_end;
    while to.cast_const() < end {
        // SAFETY: both ranges are the linker's, aligned and of the same length; nothing runs there yet. Volatile, so that it does not
        // become a call of a function that may lie there.
        unsafe {
            to.write_volatile(from.read_volatile());
            (to, from) = (to.add(1), from.add(1));
        }
    }
    let (mut to, end) = (&raw mut __ccm_zero_start, &raw const __ccm_zero_end);
    while to.cast_const() < end {
        // SAFETY: as above; what lies there is not in use yet, and zeros are what its initialiser says.
        unsafe {
            to.write_volatile(0);
            to = to.add(1);
        }
    }
    // The processor fetches what has been stored.
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
