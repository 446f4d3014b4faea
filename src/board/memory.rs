//! The test of the memory through which calibrations go to flash and back: the background's, before it is there.
#![allow(unsafe_code)] // memory by address

use crate::link::message::MemoryTest;
use crate::selftest::{Words, march};
use core::mem::MaybeUninit;
use core::ptr::{read_volatile, write_volatile};

/// Tests memory that holds nothing yet; what it held is lost.
pub fn test<T>(place: &mut MaybeUninit<T>) -> MemoryTest {
    const { assert!(align_of::<T>() >= align_of::<u32>()) };
    let first = place.as_mut_ptr().cast::<u32>();
    let mut memory = Ram {
        first,
        count: size_of::<T>() / size_of::<u32>(),
    };
    match march(&mut memory) {
        Ok(()) => MemoryTest::Passed,
        Err(index) => MemoryTest::Failed {
            address: first.wrapping_add(index) as u32,
        },
    }
}

/// Words that are read and written one by one, as the test says.
struct Ram {
    first: *mut u32,
    count: usize,
}

impl Words for Ram {
    fn count(&self) -> usize {
        self.count
    }

    fn read(&self, index: usize) -> u32 {
        // SAFETY: within the place that `test` has to itself; written before it is read.
        unsafe { read_volatile(self.first.wrapping_add(index)) }
    }

    fn write(&mut self, index: usize, word: u32) {
        // SAFETY: as above; the place is uninitialised, so that any bits may be there.
        unsafe { write_volatile(self.first.wrapping_add(index), word) }
    }
}
