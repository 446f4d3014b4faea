//! Lockstep: the guest stands still, its virtual time too, until a host process has answered.
//!
//! Two words of shared memory: `asked` counts the guest's questions, `answered` the host's answers. The side that waits
//! first looks for a while, then sleeps on the word (futex), so that two free cores are fast and one core does not starve.
//! A third word tells that the host has gone: then nothing waits any more, and QEMU is left to be ended.

use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::time::Duration;

/// Looks at the answer before sleeping: some tens of microseconds, which is what the host's answer takes if it has a core.
const LOOKS: u32 = 300;
/// Sleeps at most so long before looking again.
const NAP: Duration = Duration::from_millis(100);

/// The address that rings, and the shared words.
pub struct Bell {
    address: u64,
    words: *const AtomicU32,
}

impl Bell {
    /// Rings when the guest executes `address`.
    pub fn new(address: u64, place: *mut u8) -> Self {
        Self {
            address,
            words: place.cast_const().cast(),
        }
    }

    /// The guest address that rings.
    pub fn address(&self) -> u64 {
        self.address
    }

    fn word(&self, index: usize) -> &AtomicU32 {
        // SAFETY: within the 256 mapped bytes, aligned to 8, shared as atomics by every side.
        unsafe { &*self.words.add(index) }
    }

    /// Asks, and waits for the answer.
    pub fn ring(&self) {
        let (asked, answered, gone) = (self.word(0), self.word(1), self.word(2));
        let question = asked.load(SeqCst).wrapping_add(1);
        asked.store(question, SeqCst);
        wake(asked);
        let mut looks = 0;
        loop {
            let seen = answered.load(SeqCst);
            if seen == question || gone.load(SeqCst) != 0 {
                return;
            }
            looks += 1;
            if looks < LOOKS {
                std::hint::spin_loop();
            } else {
                sleep(answered, seen);
            }
        }
    }
}

fn wake(word: &AtomicU32) {
    // SAFETY: a futex call on a word that stays mapped.
    unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), libc::FUTEX_WAKE, 1) };
}

fn sleep(word: &AtomicU32, seen: u32) {
    let nap = libc::timespec {
        tv_sec: 0,
        tv_nsec: i64::from(NAP.subsec_nanos()),
    };
    // SAFETY: as above; the time lives through the call.
    unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), libc::FUTEX_WAIT, seen, &nap) };
}
