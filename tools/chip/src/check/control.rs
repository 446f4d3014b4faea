//! Somebody else's images (`tools/chip/control`: embassy's drivers). At 80 MHz nothing may be broken of the rules for clock, flash and pins.
//! At 170 MHz what is broken is known, and it is embassy that errs there. Anything more would be the model's fault.

use super::fixture::world;
use crate::chip::Chip;
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::{BANK_BYTES, FLASH, Processor};
use crate::rule::Rule;
use crate::surroundings::Surroundings;
use crate::time::from_us;
use anyhow::{Context, Result, ensure};
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

/// Runs both images and prints what came of it: that at 80 MHz, which must keep all rules, and that at 170 MHz.
///
/// # Errors
/// One does not do what it was written for, or the rules that it breaks are not those that are known.
pub fn run(normal: &Path, boosted: &Path) -> Result<()> {
    let pulses = one(normal, &[]).context("at 80 MHz")?;
    println!(
        "chip: control: at 80 MHz embassy keeps every rule: {pulses} pulses, flash erased and programmed"
    );
    let pulses = one(boosted, &EMBASSYS).context("at 170 MHz")?;
    println!(
        "chip: control: at 170 MHz {pulses} pulses, flash erased and programmed; what embassy breaks is known:"
    );
    for (rule, why) in EMBASSYS {
        println!("chip: control:   {}: {why}", rule.name());
    }
    Ok(())
}

/// Runs an image that breaks these rules; how many pulses its timer makes.
fn one(path: &Path, known: &[(Rule, &str)]) -> Result<u64> {
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
    let broken = processor.findings().list().iter();
    let told: Vec<_> = broken.map(|v| (v.rule, v.to_string())).collect();
    judge(&told, known)?;
    Ok(pulses)
}

fn judge(broken: &[(Rule, String)], known: &[(Rule, &str)]) -> Result<()> {
    let is_known = |rule: Rule| rule == OURS || known.iter().any(|(known, _)| *known == rule);
    let more: Vec<&str> = broken
        .iter()
        .filter(|(rule, _)| !is_known(*rule))
        .map(|(_, told)| told.as_str())
        .collect();
    ensure!(
        more.is_empty(),
        "found rules broken that embassy is not known to break:\n  {}",
        more.join("\n  ")
    );
    for (wanted, _) in known {
        ensure!(
            broken.iter().any(|(rule, _)| rule == wanted),
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
        assert!(judge(&broken, &EMBASSYS).is_ok());
        broken.push((Rule::FlashDataCache, "more".into()));
        assert!(
            judge(&broken, &EMBASSYS)
                .unwrap_err()
                .to_string()
                .contains("more")
        );
        assert!(
            judge(&broken[..1], &[]).is_err(),
            "known to be broken at 170 MHz alone"
        );
        broken.remove(4);
        broken.remove(0);
        let less = judge(&broken, &EMBASSYS).unwrap_err().to_string();
        assert!(less.contains("voltage-range"), "{less}");
    }
}
