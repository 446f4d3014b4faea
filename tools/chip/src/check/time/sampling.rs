//! The interrupts of a sample, and where they have ended.

use crate::processor::Processor;
use crate::registers;
use crate::time::from_us;
use anyhow::Result;

/// So long is looked at each time.
pub(super) const LOOK_US: u64 = 20_000;
/// After a sample's end: the intake has taken it up, and the next reading has not begun.
pub(super) const AFTER_A_SAMPLE_US: u64 = 20;
/// The interrupts of a sample: BUSY's edge, which starts the reading, and the end of the reading.
pub(super) const SAMPLING: [&str; 2] = ["EXTI9_5", "DMA1_CHANNEL2"];

/// Runs until [`AFTER_A_SAMPLE_US`] after a sample.
pub(super) fn settle(processor: &mut Processor) -> Result<()> {
    let ends = 16 + registers::interrupt(SAMPLING[1]);
    let before = processor.times.of(ends).count;
    while processor.times.of(ends).count == before {
        processor.run(from_us(1))?;
    }
    processor.run(from_us(AFTER_A_SAMPLE_US)).map(drop)
}
