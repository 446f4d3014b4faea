//! What the sampling interrupt takes of a sample, without and with the flash's wait states.

use super::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::Processor;
use crate::registers;
use crate::time::from_us;
use anyhow::{Result, ensure};
use std::fmt;

/// Start-up takes some 16 ms; then so long is looked at.
const START_US: u64 = 30_000;
const LOOK_US: u64 = 20_000;
/// The interrupts of a sample: BUSY's edge, which starts the reading, and the end of the reading.
const SAMPLING: [&str; 2] = ["EXTI9_5", "DMA1_CHANNEL2"];
/// What they may take together, with wait states, of the 8,500 cycles that a sample has at 20 kHz.
const WANTED_CYCLES: u64 = 1500;

pub fn run(image: &Image) -> Result<String> {
    let mut processor = start(image, 10, Start::default())?;
    let result = measure(&mut processor);
    judge(&mut processor, result)
}

fn measure(processor: &mut Processor) -> Result<String> {
    processor.run(from_us(START_US))?;
    let [without, with] = [false, true].map(|counted| -> Result<Cycles> {
        processor.set_wait_states(counted);
        spent(processor)
    });
    let (without, with) = (without?, with?);
    let said =
        format!("the sampling interrupts take {without} cycles a sample; with wait states {with}");
    ensure!(
        with.worst <= WANTED_CYCLES,
        "{said}, wanted {WANTED_CYCLES} or fewer"
    );
    Ok(said)
}

/// Cycles of both sampling interrupts of a sample together: the mean, and the sum of the longest of each.
#[derive(Clone, Copy, Debug)]
struct Cycles {
    mean: u64,
    worst: u64,
}

impl fmt::Display for Cycles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} at most)", self.mean, self.worst)
    }
}

/// What the sampling interrupts take from now on.
fn spent(processor: &mut Processor) -> Result<Cycles> {
    processor.times.restart();
    processor.run(from_us(LOOK_US))?;
    let mut together = Cycles { mean: 0, worst: 0 };
    for name in SAMPLING {
        let spent = processor.times.of(16 + registers::interrupt(name));
        ensure!(spent.count > 0, "the interrupt {name} never came");
        together.mean += spent.sum / spent.count;
        together.worst += spent.worst;
    }
    Ok(together)
}
