//! Clock, regulator and wait states.

use crate::bench::{set, wait_us};
use crate::steps::watchdog;
use chip::chip::Chip;
use chip::rule::Rule;

/// Clocks of everything that the tests touch.
pub fn clocks(chip: &mut Chip) {
    set(chip, at!(RCC.apb1enr1()), 1 << 28 | 3);
    set(chip, at!(RCC.apb2enr()), 1 << 14 | 1 << 12 | 1);
    set(chip, at!(RCC.ahb2enr()), 1 << 13 | 7);
}

/// 170 MHz as the manual wants it.
pub fn full_speed(chip: &mut Chip) {
    full_speed_without(chip, None);
}

/// The same; `skip` leaves a step out.
fn full_speed_without(chip: &mut Chip, skip: Option<Rule>) {
    let skips = |rule| skip == Some(rule);
    clocks(chip);
    if !skips(Rule::WatchdogFirst) {
        watchdog(chip);
    }
    if !skips(Rule::VoltageRange) {
        chip.write(at!(PWR.cr5()), 4, 0);
    }
    if !skips(Rule::FlashLatency) {
        set(chip, at!(FLASH.acr()), 4);
    }
    // HSI / 4 * 85 / 2; or HSI / 8, which is below the least input.
    let divider = if skips(Rule::Pll) { 0x7 } else { 3 };
    chip.write(at!(RCC.pllcfgr()), 4, 2 | divider << 4 | 85 << 8 | 1 << 24);
    set(chip, at!(RCC.cr()), 1 << 24);
    wait_us(chip, 50);
    let (half, pll) = (8 << 4, 3);
    if skips(Rule::PrescalerFirst) {
        chip.write(at!(RCC.cfgr()), 4, half | pll);
    } else if skips(Rule::ClockStep) {
        chip.write(at!(RCC.cfgr()), 4, pll);
    } else {
        chip.write(at!(RCC.cfgr()), 4, 1 | half);
        chip.write(at!(RCC.cfgr()), 4, half | pll);
    }
    wait_us(chip, 2);
    chip.write(at!(RCC.cfgr()), 4, pll);
}

trips! {
    pll {
        an_input_below_the_least: |chip| full_speed_without(chip, Some(Rule::Pll));
    }
    voltage_range {
        full_speed_without_the_boost: |chip| full_speed_without(chip, Some(Rule::VoltageRange));
    }
    flash_latency {
        full_speed_without_wait_states: |chip| full_speed_without(chip, Some(Rule::FlashLatency));
    }
    clock_step {
        full_speed_in_one_step: |chip| full_speed_without(chip, Some(Rule::ClockStep));
    }
    prescaler_first {
        both_in_one_write: |chip| full_speed_without(chip, Some(Rule::PrescalerFirst));
    }
    watchdog_first {
        a_clock_without_watchdog: |chip| full_speed_without(chip, Some(Rule::WatchdogFirst));
    }
}
