//! The image starts, sets clock, pins and converters up, and samples.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::{End, Processor};
use crate::time::{from_us, to_ns};
use anyhow::{Result, ensure};

/// Samples to see, and the time that they and the start may take: 20 kHz, and a tenth of a second.
const SAMPLES: u64 = 1000;
const PATIENCE_MS: u64 = 150;

pub fn run(image: &Image) -> Result<String> {
    let mut processor = start(image, 1, Start::default())?;
    let result = sample(&mut processor);
    judge(&mut processor, result)
}

fn sample(processor: &mut Processor) -> Result<String> {
    for _ in 0..PATIENCE_MS {
        let end = processor.run(from_us(1000))?;
        ensure!(end == End::Time, "the supply went by itself");
        let taken = processor.chip().around.converter.conversions();
        if taken >= SAMPLES {
            let at_us = to_ns(processor.now()) / 1000;
            let cycles = processor.cycles();
            return Ok(format!(
                "{taken} conversions after {at_us} us, {cycles} cycles"
            ));
        }
    }
    let taken = processor.chip().around.converter.conversions();
    anyhow::bail!(
        "found {taken} conversions in {PATIENCE_MS} ms, wanted {SAMPLES}; the processor is at {:#010x}",
        processor.program_counter()
    )
}
