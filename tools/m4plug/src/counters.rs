//! Counters in guest memory, 64 bits each: 0 instructions, 1 estimated cycles, 2 taken branches, 3 unused, 4 + k class k.
//!
//! Instructions are exact. Cycles follow `thumb::cost`; a taken branch adds `thumb::REFILL`. QEMU's blocks also end where nothing branches, at
//! the ends of its pages: the next one's first instruction then follows this one's last. What a branch means for the instruction after it is
//! not modelled, but for the refill.

use crate::qemu::{self, Block, Translated};
use std::ffi::{c_uint, c_void};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering::Relaxed};
use thumb::{Class, Cut, Flow, Instruction, REFILL, cost};

/// QEMU's inline operation: add a number to a 64-bit word.
const ADD: i32 = 0;

/// The block's counters.
pub struct Counters(*mut u64);

/// Where the two counters of taken branches are, for the callbacks, which have no room for it.
static COUNTERS: AtomicPtr<u64> = AtomicPtr::new(std::ptr::null_mut());
/// The last instruction was a branch, and this is the address behind it.
static BRANCHED: AtomicBool = AtomicBool::new(false);
static BEHIND: AtomicU64 = AtomicU64::new(0);

/// The end of the block that was translated last. What is behind it is translated next, as soon as that block has run.
static CUT: Mutex<Option<Cut>> = Mutex::new(None);

/// The instruction that runs before a block's first one, where no branch lies between. The block's own end is kept for the next.
fn before(instructions: &[Translated]) -> Option<Instruction> {
    let (first, last) = (instructions.first()?, instructions.last()?);
    let mut cut = CUT.lock().ok()?;
    let known = std::mem::replace(&mut *cut, Cut::of(last.address, last.instruction));
    known?.before(first.address)
}

impl Counters {
    /// At a place of the guest's memory.
    pub fn new(place: *mut u8) -> Self {
        let words = place.cast::<u64>();
        COUNTERS.store(words, Relaxed);
        Self(words)
    }

    /// Makes every instruction of a block count when it runs.
    pub fn attach(&self, block: *mut Block, instructions: &[Translated]) {
        let cut = before(instructions);
        let mut before = cut.as_ref();
        for Translated {
            handle,
            instruction,
            ..
        } in instructions
        {
            let cycles = u64::from(cost(before, instruction));
            for (counter, value) in [(0, 1), (1, cycles), (4 + instruction.class as usize, 1)] {
                // SAFETY: the counter lies within the 256 mapped bytes (4 + 17 words); the handle is of this translation.
                unsafe {
                    let word = self.0.add(counter).cast();
                    qemu::qemu_plugin_register_vcpu_insn_exec_inline(*handle, ADD, word, value);
                }
            }
            before = Some(instruction);
        }
        self.attach_branches(block, instructions);
    }

    /// A block that ends in a branch and is not followed by the next address: the branch was taken.
    fn attach_branches(&self, block: *mut Block, instructions: &[Translated]) {
        let (Some(first), Some(last)) = (instructions.first(), instructions.last()) else {
            return;
        };
        // SAFETY: QEMU's own functions, handles of this translation; addresses go as user data, never dereferenced.
        unsafe {
            qemu::qemu_plugin_register_vcpu_tb_exec_cb(
                block,
                entered,
                0,
                first.address as *mut c_void,
            );
            if last.instruction.class == Class::Branch && last.instruction.flow != Flow::Next {
                let behind = last.address + u64::from(last.instruction.size);
                qemu::qemu_plugin_register_vcpu_insn_exec_cb(
                    last.handle,
                    branched,
                    0,
                    behind as *mut c_void,
                );
            }
        }
    }
}

extern "C" fn branched(_: c_uint, behind: *mut c_void) {
    BEHIND.store(behind as u64, Relaxed);
    BRANCHED.store(true, Relaxed);
}

extern "C" fn entered(_: c_uint, start: *mut c_void) {
    if !BRANCHED.load(Relaxed) {
        return;
    }
    BRANCHED.store(false, Relaxed);
    if start as u64 != BEHIND.load(Relaxed) {
        let counters = COUNTERS.load(Relaxed);
        // SAFETY: set before the first block was translated; only the guest's one processor thread writes there.
        unsafe {
            *counters.add(1) += u64::from(REFILL);
            *counters.add(2) += 1;
        }
    }
}
