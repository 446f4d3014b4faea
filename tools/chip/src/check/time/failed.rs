//! What a sample takes whose reading fails, and those after it, until all is well again.

use super::sampling::{AFTER_A_SAMPLE_US, LOOK_US, SAMPLING, settle};
use crate::processor::Processor;
use crate::registers;
use crate::rule::Rule;
use crate::surroundings::ByteFault;
use crate::time::from_us;
use anyhow::{Result, ensure};

/// From one sampling instant to the next.
const INTERVAL_US: u64 = 50;
/// The processor stands still for so long: the instant after [`AFTER_A_SAMPLE_US`] is missed and the next one too, and the sample that
/// follows ends before the third.
const STILL_US: u64 = 90;
/// What is left then until that third one: that sample, and no other.
const REST_US: u64 = 20;
/// So many instants are looked at: the board calls the interrupt by hand at every fourth without an edge of BUSY.
const INSTANTS: u32 = 12;
/// A byte of no frame.
const STRAY: u8 = 0xA5;

/// A way in which a reading fails.
struct Failure {
    what: &'static str,
    begin: fn(&mut Processor),
}

/// All of them. A further one is a line here.
const FAILURES: [Failure; 5] = [
    Failure {
        what: "a wrong check sum",
        begin: |processor| next_byte(processor, 1, ByteFault::Changed),
    },
    Failure {
        what: "a byte of the first chip that is lost",
        begin: |processor| next_byte(processor, 0, ByteFault::Lost),
    },
    Failure {
        what: "a byte of the second chip that is lost",
        begin: |processor| next_byte(processor, 1, ByteFault::Lost),
    },
    Failure {
        what: "a byte too many",
        begin: |processor| processor.chip().disturb_bus(STRAY),
    },
    Failure {
        what: "no edge of BUSY",
        begin: |processor| processor.chip().around.silent = true,
    },
];

fn next_byte(processor: &mut Processor, chip: usize, fault: ByteFault) {
    processor.chip().around.byte_fault = Some((chip, fault, 1));
}

/// The longest sample, with instants missed before it and without, and what was wrong with its reading.
///
/// # Errors
/// Unicorn's; or no reading failed.
pub fn longest(processor: &mut Processor) -> Result<(u64, &'static str)> {
    let mut longest = (0, "");
    for Failure { what, begin } in FAILURES {
        for missed in [false, true] {
            let most = most(processor, begin, missed)?;
            longest = longest.max((most, what));
        }
    }
    // What the stray byte itself does is no fault of the image.
    for rule in [Rule::SpiStale, Rule::SpiSelect, Rule::SpiFifo] {
        processor.findings().forgive(rule);
    }
    Ok(longest)
}

/// The longest of the samples after this.
fn most(processor: &mut Processor, begin: fn(&mut Processor), missed: bool) -> Result<u64> {
    settle(processor)?;
    begin(processor);
    let mut most = 0;
    if missed {
        processor.chip().halt(from_us(STILL_US));
        most = taken(processor, REST_US)?;
    }
    for _ in 0..INSTANTS {
        most = most.max(taken(processor, INTERVAL_US)?);
    }
    processor.chip().around.silent = false;
    let left = processor.chip().around.byte_fault;
    ensure!(
        left.is_none(),
        "found {left:?} after {INSTANTS} instants, wanted a reading that fails"
    );
    processor.run(from_us(LOOK_US))?;
    Ok(most)
}

/// What both sampling interrupts take within a time that holds one sample.
fn taken(processor: &mut Processor, us: u64) -> Result<u64> {
    processor.times.restart();
    processor.run(from_us(us))?;
    let spent = |name| processor.times.of(16 + registers::interrupt(name)).sum;
    Ok(SAMPLING.map(spent).iter().sum())
}

const _: () = assert!(AFTER_A_SAMPLE_US + STILL_US + REST_US < 3 * INTERVAL_US);
