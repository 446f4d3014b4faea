//! Somebody else's image (`tools/chip/control`: embassy's drivers): what it breaks of the rules for clock, flash and pins is known, and
//! it is embassy that errs there. Anything more would be the model's fault.

use super::fixture::world;
use crate::chip::Chip;
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::{BANK_BYTES, FLASH, Processor};
use crate::rule::Rule;
use crate::surroundings::Surroundings;
use crate::time::from_us;
use anyhow::{Result, ensure};
use std::path::Path;

/// Rules that embassy-stm32 0.6 breaks, and why it is not the model that errs.
const EMBASSYS: [(Rule, &str); 4] = [
    (
        Rule::VoltageRange,
        "R1MODE is written at bit 0, as stm32-metapac 21 has it; it is bit 8 in ST's stm32g474xx.h and in the crate stm32g4 0.16",
    ),
    (
        Rule::FlashLatency,
        "four wait states are enough for 170 MHz only with the boosted regulator, which is not on",
    ),
    (
        Rule::PrescalerFirst,
        "ST's HAL_RCC_ClockConfig halves the bus, then changes the source, and takes the half back last",
    ),
    (
        Rule::ClockStep,
        "the half is taken back in the write that changes the source, so that the bus never runs at it",
    ),
];
/// The project's own rule, which is not the chip's.
const OURS: Rule = Rule::WatchdogFirst;
/// The run, and what its timer makes in it: 20 kHz but for the start and the erase of a page.
const RUN_US: u64 = 100_000;
const PULSES: std::ops::RangeInclusive<u64> = 1900..=2000;
/// What the image stores.
const PATTERN: [u8; 16] = *b"control control.";

/// Runs the image and prints what came of it.
///
/// # Errors
/// It does not do what it was written for, or the rules that it breaks are not those that are known.
pub fn run(path: &Path) -> Result<()> {
    let (world, flash) = world(13)?;
    let code = Image::open(path)?.flash(FLASH, BANK_BYTES as usize)?;
    let around = Surroundings::new(world, flash.clone());
    let mut processor = Processor::start(&code, Chip::new(around, Start::default()))?;
    processor.run(from_us(RUN_US))?;
    let pulses = processor.chip().around.converter.conversions();
    ensure!(
        PULSES.contains(&pulses),
        "found {pulses} pulses of the timer in {RUN_US} us, wanted {PULSES:?}"
    );
    ensure!(
        flash.0.borrow().bytes().starts_with(&PATTERN),
        "the flash does not hold what was stored"
    );
    ensure!(
        processor.chip().around.lamp,
        "the lamp is off: the flash's driver reports an error"
    );
    judge(
        &processor
            .findings()
            .list()
            .iter()
            .map(|v| (v.rule, v.to_string()))
            .collect::<Vec<_>>(),
    )?;
    println!(
        "chip: control: {pulses} pulses, flash erased and programmed; what embassy breaks is known:"
    );
    for (rule, why) in EMBASSYS {
        println!("chip: control:   {}: {why}", rule.name());
    }
    Ok(())
}

fn judge(broken: &[(Rule, String)]) -> Result<()> {
    let known = |rule: Rule| rule == OURS || EMBASSYS.iter().any(|(known, _)| *known == rule);
    let more: Vec<&str> = broken
        .iter()
        .filter(|(rule, _)| !known(*rule))
        .map(|(_, told)| told.as_str())
        .collect();
    ensure!(
        more.is_empty(),
        "found rules broken that embassy is not known to break:\n  {}",
        more.join("\n  ")
    );
    for (wanted, _) in EMBASSYS {
        ensure!(
            broken.iter().any(|(rule, _)| *rule == wanted),
            "found {} kept, wanted it broken: embassy has mended it, or the model no longer sees it",
            wanted.name()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_more_and_a_rule_less_both_fail() {
        let mut broken: Vec<(Rule, String)> =
            EMBASSYS.map(|(rule, _)| (rule, String::new())).into();
        assert!(judge(&broken).is_ok());
        broken.push((Rule::FlashDataCache, "more".into()));
        assert!(judge(&broken).unwrap_err().to_string().contains("more"));
        broken.remove(4);
        broken.remove(0);
        let less = judge(&broken).unwrap_err().to_string();
        assert!(less.contains("voltage-range"), "{less}");
    }
}
