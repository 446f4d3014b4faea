//! What a sample takes whose reading fails, and those after it, until all is well again.

use super::sampling::{AFTER_A_SAMPLE_US, LOOK_US, SAMPLING, settle};
use crate::processor::Processor;
use crate::registers;
use crate::rule::Rule;
use crate::surroundings::ByteFault;
use crate::time::from_us;
use anyhow::{Result, ensure};
use courier_sensor::drivers::ad7606c::FRAME_BYTES;

/// From one sampling instant to the next.
const INTERVAL_US: u64 = 50;
/// The processor stands still for so long: the instant after [`AFTER_A_SAMPLE_US`] is missed and the next one too, and the sample that
/// follows ends before the third: some 40 us of the first interval are over by then. With 90 the looks that follow began at an instant, and one
/// that held the interrupts of two was told as one sample's.
const STILL_US: u64 = 85;
/// What is left then until that third one: that sample, and no other.
const REST_US: u64 = 20;
/// So many instants are looked at: the board calls the interrupt by hand at every sixth without an edge of BUSY.
const INSTANTS: u32 = 12;
/// So many readings in a row fail until the chips are set anew (`src/drivers/converter/revival.rs`, `FAILURES`).
const IN_A_ROW: u32 = 20;
/// The failures, twice as many instants as setting the chips anew takes, and some that are good again.
const INSTANTS_ANEW: u32 = 300;
/// A byte of no frame.
const STRAY: u8 = 0xA5;

/// A way in which a reading fails.
struct Failure {
    what: &'static str,
    begin: fn(&mut Processor),
    /// Instants until all is well again.
    instants: u32,
}

/// All of them. A further one is a line here.
const FAILURES: [Failure; 6] = [
    Failure {
        what: "a wrong check sum",
        begin: |processor| next_byte(processor, 1, ByteFault::Changed),
        instants: INSTANTS,
    },
    Failure {
        what: "a byte of the first chip that is lost",
        begin: |processor| next_byte(processor, 0, ByteFault::Lost),
        instants: INSTANTS,
    },
    Failure {
        what: "a byte of the second chip that is lost",
        begin: |processor| next_byte(processor, 1, ByteFault::Lost),
        instants: INSTANTS,
    },
    Failure {
        what: "a byte too many",
        begin: |processor| processor.chip().disturb_bus(STRAY),
        instants: INSTANTS,
    },
    Failure {
        what: "no edge of BUSY",
        begin: |processor| processor.chip().around.silent = true,
        instants: INSTANTS,
    },
    ANEW,
];

/// So many wrong check sums in a row that the converters are set anew.
const ANEW: Failure = Failure {
    what: "converters that are set anew",
    begin: |processor| {
        let bytes = IN_A_ROW * FRAME_BYTES as u32;
        processor.chip().around.byte_fault = Some((1, ByteFault::Changed, bytes));
    },
    instants: INSTANTS_ANEW,
};

fn next_byte(processor: &mut Processor, chip: usize, fault: ByteFault) {
    processor.chip().around.byte_fault = Some((chip, fault, 1));
}

/// The longest sample, with instants missed before it and without, and what was wrong with its reading.
///
/// # Errors
/// Unicorn's; or no reading failed.
pub fn longest(processor: &mut Processor) -> Result<(u64, &'static str)> {
    let mut longest = (0, "");
    for failure in &FAILURES {
        for missed in [false, true] {
            let most = most(processor, failure, missed)?;
            longest = longest.max((most, failure.what));
        }
    }
    // What the stray byte itself does is no fault of the image.
    for rule in [Rule::SpiStale, Rule::SpiSelect, Rule::SpiFifo] {
        processor.findings().forgive(rule);
    }
    Ok(longest)
}

/// The longest sample while the converters are set anew.
///
/// # Errors
/// Unicorn's; or no reading failed.
pub fn longest_anew(processor: &mut Processor) -> Result<u64> {
    most(processor, &ANEW, false)
}

/// The longest of the samples after this.
fn most(processor: &mut Processor, failure: &Failure, missed: bool) -> Result<u64> {
    settle(processor)?;
    (failure.begin)(processor);
    let mut most = 0;
    if missed {
        processor.chip().halt(from_us(STILL_US));
        most = taken(processor, REST_US)?;
    }
    for _ in 0..failure.instants {
        most = most.max(taken(processor, INTERVAL_US)?);
    }
    processor.chip().around.silent = false;
    let left = processor.chip().around.byte_fault;
    ensure!(
        left.is_none(),
        "found {left:?} after {} instants, wanted a reading that fails",
        failure.instants
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
