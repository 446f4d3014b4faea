//! The first instructions, the only ones that run from flash: they copy the rest into RAM. Where it lies is `link.x`'s.

use super::{isr_fault, isr_nmi, main};

/// An entry of the vector table.
#[repr(C)]
union Vector {
    stack: *const u32,
    handler: unsafe extern "C" fn(),
    none: u32,
}

// SAFETY: numbers and addresses that nobody changes.
unsafe impl Sync for Vector {}

unsafe extern "C" {
    static __stack_top: u32;
}

/// Stack, reset, and the faults; no interrupt is on. The processor keeps its table at address 0, where bank 1 is after a reset.
#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: [Vector; 8] = [
    Vector {
        stack: &raw const __stack_top,
    },
    Vector { handler: reset },
    Vector { handler: isr_nmi },
    Vector { handler: isr_fault },
    Vector { handler: isr_fault },
    Vector { handler: isr_fault },
    Vector { handler: isr_fault },
    Vector { none: 0 },
];

/// Copies the program, clears what begins as zeros, and goes on in RAM.
#[unsafe(naked)]
#[unsafe(no_mangle)]
#[unsafe(link_section = ".reset")]
unsafe extern "C" fn reset() {
    core::arch::naked_asm!(
        "cpsid i",
        "ldr r0, =__code_start",
        "ldr r1, =__code_stored",
        "ldr r2, =__code_end",
        "2:",
        "cmp r0, r2",
        "bhs 3f",
        "ldr r3, [r1], #4",
        "str r3, [r0], #4",
        "b 2b",
        "3:",
        "ldr r2, =__zero_end",
        "movs r3, #0",
        "4:",
        "cmp r0, r2",
        "bhs 5f",
        "str r3, [r0], #4",
        "b 4b",
        "5:",
        "dsb",
        "isb",
        "cpsie i",
        "ldr r0, ={main}",
        "bx r0",
        main = sym main,
    )
}
