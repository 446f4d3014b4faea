//! Questions to the host: see [`crate::emulation`].
#![allow(unsafe_code)] // memory that the host shares

use crate::emulation::{
    DATA_BYTES, FAILED, HEADER_BYTES, HUNG, MAILBOX_BASE, MAILBOX_STRIDE, Operation, POWER_LOST,
    STACK_SPENT, Word,
};
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{Ordering::SeqCst, compiler_fence};

/// The host could not do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

/// One of the two mailboxes. A value of this type is the right to ask there: each context owns its own.
#[derive(Clone, Copy, Debug)]
pub struct Mailbox {
    base: u32,
}

impl Mailbox {
    /// Mailbox `index`: [`crate::emulation::INTERRUPT`] or [`crate::emulation::BACKGROUND`].
    pub const fn new(index: usize) -> Self {
        Self {
            base: MAILBOX_BASE + index as u32 * MAILBOX_STRIDE,
        }
    }

    fn word(self, word: Word) -> *mut u32 {
        (self.base + 4 * word as u32) as *mut u32
    }

    fn data(self) -> *mut u8 {
        (self.base + HEADER_BYTES) as *mut u8
    }

    /// Asks with data, takes at most `answer.len()` bytes of the answer's, and returns the answer's word.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn ask(
        self,
        operation: Operation,
        argument: u32,
        question: &[u8],
        answer: &mut [u8],
    ) -> Result<u32, Refused> {
        let length = question.len().max(answer.len());
        if length > DATA_BYTES {
            return Err(Refused);
        }
        // SAFETY: the mailbox lies in RAM that the linker gives to nobody, the data are within it, and the host touches
        // them only between the bell and the answer, while this processor stands still.
        unsafe {
            for (index, byte) in question.iter().enumerate() {
                write_volatile(self.data().add(index), *byte);
            }
            write_volatile(self.word(Word::Operation), operation as u32);
            write_volatile(self.word(Word::Argument), argument);
            write_volatile(self.word(Word::Length), length as u32);
            write_volatile(self.word(Word::Ticks), super::clock::ticks());
            let sequence = read_volatile(self.word(Word::Sequence)).wrapping_add(1);
            compiler_fence(SeqCst);
            write_volatile(self.word(Word::Sequence), sequence);
            courier_bell();
            compiler_fence(SeqCst);
            let word = read_volatile(self.word(Word::Answer));
            match word {
                FAILED => return Err(Refused),
                POWER_LOST => cortex_m::peripheral::SCB::sys_reset(),
                HUNG => loop {
                    cortex_m::asm::nop();
                },
                STACK_SPENT => _ = spend_stack(word),
                _ => {}
            }
            for (index, byte) in answer.iter_mut().enumerate() {
                *byte = read_volatile(self.data().add(index));
            }
            Ok(word)
        }
    }
}

/// Calls itself until there is no stack.
#[inline(never)]
fn spend_stack(word: u32) -> u32 {
    let frame = core::hint::black_box([word; 16]);
    match frame[0] {
        0 => 0, // never, which the compiler does not know
        deeper => spend_stack(deeper) ^ core::hint::black_box(frame)[1],
    }
}

/// The plugin watches this address.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn courier_bell() {
    // SAFETY: does nothing; keeps the function from being folded away.
    unsafe { core::arch::asm!("nop") };
}
