//! Operations on a lock-free queue that have no panic path, for interrupts.
//!
//! heapless divides by a queue's length, of which the compiler does not know that it is not zero. Each function here looks at it first,
//! which is what leaves the division's panic out of an interrupt's call graph (`cargo xtask firmware` checks that). Where the length is a
//! constant, the look leaves out the division as well ([`enqueue_in`]).

use heapless::spsc::{Consumer, Producer};

/// Whether there is room for one more.
#[inline(always)]
pub fn has_room<T>(queue: &Producer<'_, T>) -> bool {
    queue.capacity() != usize::MAX && queue.ready()
}

/// Adds one; gives it back if there is no room.
///
/// # Errors
/// The item itself.
#[inline(always)]
pub fn enqueue<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    if queue.capacity() == usize::MAX {
        return Err(item);
    }
    queue.enqueue(item)
}

/// The same with a queue of the length `N`, a power of two: no division is left. With one of another length nothing is added.
///
/// # Errors
/// The item itself.
#[inline(always)]
pub fn enqueue_in<const N: usize, T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    // One place of a queue stays empty.
    if queue.capacity() != N - 1 {
        return Err(item);
    }
    queue.enqueue(item)
}

/// Takes the oldest.
#[inline(always)]
pub fn dequeue<T>(queue: &mut Consumer<'_, T>) -> Option<T> {
    if queue.capacity() == usize::MAX {
        return None;
    }
    queue.dequeue()
}
