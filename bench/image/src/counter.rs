//! Counters that the plugin keeps in the last page of RAM, and statistics over them.

use core::ptr::read_volatile;

/// Where the host puts them.
const COUNTERS: *const u64 = 0x21FF_F000 as *const u64;

/// Instructions and estimated cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Exact.
    pub instructions: u32,
    /// By the public timings.
    pub cycles: u32,
}

/// Now.
#[inline(always)]
pub fn read() -> Reading {
    // SAFETY: RAM that the plugin writes and nothing else uses; the low words suffice for differences.
    unsafe {
        Reading {
            instructions: read_volatile(COUNTERS.cast()),
            cycles: read_volatile(COUNTERS.add(1).cast()),
        }
    }
}

/// Runs `work` and returns what it took, without the cost of looking.
#[inline(never)]
pub fn measure<R>(work: impl FnOnce() -> R) -> (Reading, R) {
    let before = read();
    let result = work();
    let after = read();
    let taken = Reading {
        instructions: after.instructions.wrapping_sub(before.instructions),
        cycles: after.cycles.wrapping_sub(before.cycles),
    };
    (taken, result)
}

/// Worst and mean of many readings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    worst: Reading,
    instructions: u64,
    cycles: u64,
    count: u32,
}

impl Statistics {
    /// Takes in one.
    pub fn add(&mut self, reading: Reading) {
        self.worst.instructions = self.worst.instructions.max(reading.instructions);
        self.worst.cycles = self.worst.cycles.max(reading.cycles);
        self.instructions += u64::from(reading.instructions);
        self.cycles += u64::from(reading.cycles);
        self.count += 1;
    }

    /// One line for the host: name, count, instructions worst and mean, cycles worst and mean, the cost of looking taken off.
    pub fn print(&self, name: &str) {
        let empty = empty();
        let count = f64::from(self.count.max(1));
        let mean = |sum: u64, looking: u32| sum as f64 / count - f64::from(looking);
        cortex_m_semihosting::hprintln!(
            "cost {} {} {} {:.1} {} {:.1}",
            name,
            self.count,
            self.worst.instructions - empty.instructions,
            mean(self.instructions, empty.instructions),
            self.worst.cycles - empty.cycles,
            mean(self.cycles, empty.cycles)
        );
    }
}

/// What looking itself costs.
fn empty() -> Reading {
    measure(|| ()).0
}
