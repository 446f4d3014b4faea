//! The converter of the temperature.

use crate::bench::{assert_kept, chip, set, wait_us};
use crate::clock::full_speed;
use chip::chip::Chip;
use chip::peripheral::flash::Start;

/// ADC1 ready for the temperature.
fn adc(chip: &mut Chip) {
    full_speed(chip);
    set(chip, at!(ADC12_COMMON.ccr()), 3 << 16 | 1 << 23);
    chip.write(at!(ADC1.cr()), 4, 0);
    set(chip, at!(ADC1.cr()), 1 << 28);
    wait_us(chip, 25);
    set(chip, at!(ADC1.cr()), 1 << 31);
    wait_us(chip, 25);
    set(chip, at!(ADC1.smpr2()), 7 << 18);
    chip.write(at!(ADC1.sqr1()), 4, 16 << 6);
    set(chip, at!(ADC1.cr()), 1);
    wait_us(chip, 25);
}

fn convert(chip: &mut Chip) {
    set(chip, at!(ADC1.cr()), 1 << 2);
    wait_us(chip, 50);
    let _ = chip.read(at!(ADC1.dr()), 4);
}

trips! {
    adc_sequence {
        on_without_its_regulator: |chip| {
            full_speed(chip);
            chip.write(at!(ADC1.cr()), 4, 1);
        };
    }
    adc_stale {
        a_conversion_long_after_the_one_before: |chip| {
            adc(chip);
            convert(chip);
            wait_us(chip, 100_000);
            convert(chip);
        };
    }
}

#[test]
fn two_readings_in_a_row_are_fresh() {
    let mut chip = chip(Start::default());
    adc(&mut chip);
    for _ in 0..3 {
        chip.write(at!(IWDG.kr()), 4, 0xAAAA);
        convert(&mut chip);
        convert(&mut chip);
        wait_us(&mut chip, 100_000);
    }
    assert_kept(&chip);
}

#[test]
fn the_second_of_a_sequence_is_fresh() {
    let mut chip = chip(Start::default());
    adc(&mut chip);
    // Overwriting; two conversions of channel 16.
    set(&mut chip, at!(ADC1.cfgr()), 1 << 12);
    chip.write(at!(ADC1.sqr1()), 4, 16 << 12 | 16 << 6 | 1);
    for _ in 0..3 {
        chip.write(at!(IWDG.kr()), 4, 0xAAAA);
        convert(&mut chip);
        wait_us(&mut chip, 100_000);
    }
    assert_kept(&chip);
}
