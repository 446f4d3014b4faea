//! What the sampling interrupt takes of a sample, without and with the flash's wait states.

use super::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::Processor;
use crate::registers;
use crate::time::from_us;
use anyhow::{Result, ensure};

/// Start-up takes some 16 ms; then so long is looked at.
const START_US: u64 = 30_000;
const LOOK_US: u64 = 20_000;
/// Cycles of a sample: 170 MHz at 20 kHz.
const SAMPLE_CYCLES: u64 = 170_000_000 / 20_000;

pub fn run(image: &Image) -> Result<String> {
    let mut processor = start(image, 10, Start::default())?;
    let result = measure(&mut processor);
    judge(&mut processor, result)
}

fn measure(processor: &mut Processor) -> Result<String> {
    processor.run(from_us(START_US))?;
    let sampling = 16 + registers::interrupt("EXTI9_5");
    let [without, with] = [false, true].map(|counted| -> Result<(u64, u64)> {
        processor.set_wait_states(counted);
        processor.times.restart();
        processor.run(from_us(LOOK_US))?;
        let spent = processor.times.of(sampling);
        Ok((spent.sum / spent.count.max(1), spent.worst))
    });
    let ((mean, worst), (mean_waiting, worst_waiting)) = (without?, with?);
    ensure!(mean > 0, "the sampling interrupt never came");
    let said = format!(
        "the sampling interrupt takes {mean} cycles, {worst} at most; with wait states {mean_waiting} and {worst_waiting}"
    );
    ensure!(
        worst_waiting < SAMPLE_CYCLES,
        "{said}, of {SAMPLE_CYCLES} that a sample has"
    );
    Ok(said)
}
