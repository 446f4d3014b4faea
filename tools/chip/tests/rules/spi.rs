//! The converters' buses.

use crate::bench::{assert_kept, chip, wait_us};
use crate::clock::full_speed;
use crate::steps::{pins, pulse};
use chip::chip::Chip;
use chip::peripheral::flash::Start;

const MODE: u32 = 1 << 1 | 1 << 2 | 2 << 3 | 1 << 6 | 1 << 8 | 1 << 9;

/// SPI1 as the converters want it, at full speed.
pub fn start(chip: &mut Chip) {
    full_speed(chip);
    pins(chip);
    chip.write(at!(SPI1.cr2()), 4, 7 << 8 | 1 << 12);
    chip.write(at!(SPI1.cr1()), 4, MODE);
}

/// Chip 0's select.
pub fn select(chip: &mut Chip, low: bool) {
    chip.write(at!(GPIOA.bsrr()), 4, if low { 1 << 20 } else { 1 << 4 });
}

pub fn send(chip: &mut Chip) {
    chip.write(at!(SPI1.dr8()), 1, 0);
}

trips! {
    spi_mode {
        another_polarity: |chip| {
            start(chip);
            chip.write(at!(SPI1.cr1()), 4, 0);
            chip.write(at!(SPI1.cr1()), 4, MODE & !2);
        };
        a_bus_that_is_too_fast: |chip| {
            start(chip);
            chip.write(at!(SPI1.cr1()), 4, 0);
            // 85 MHz.
            chip.write(at!(SPI1.cr1()), 4, MODE & !(7 << 3));
        };
    }
    spi_fifo {
        a_read_of_an_empty_one: |chip| {
            start(chip);
            let _ = chip.read(at!(SPI1.dr8()), 1);
        };
        a_write_to_a_full_one: |chip| {
            start(chip);
            for _ in 0..6 {
                send(chip);
            }
        };
        bytes_that_nobody_fetches: |chip| {
            start(chip);
            for _ in 0..5 {
                send(chip);
                wait_us(chip, 1);
            }
        };
    }
    spi_stale_byte {
        a_select_with_a_byte_left_over: |chip| {
            start(chip);
            send(chip);
            wait_us(chip, 1);
            select(chip, true);
        };
    }
    spi_select {
        a_select_that_ends_within_a_byte: |chip| {
            start(chip);
            select(chip, true);
            send(chip);
            select(chip, false);
        };
    }
}

#[test]
fn a_start_that_keeps_the_rules_trips_none() {
    let mut chip = chip(Start::default());
    start(&mut chip);
    pulse(&mut chip, 1);
    select(&mut chip, true);
    for _ in 0..3 {
        send(&mut chip);
        wait_us(&mut chip, 1);
        let _ = chip.read(at!(SPI1.dr8()), 1);
    }
    select(&mut chip, false);
    chip.write(at!(USART1.brr()), 4, 170);
    chip.write(at!(USART1.cr1()), 4, 1 << 29 | 1 << 3 | 1 << 2 | 1);
    chip.write(at!(USART1.tdr()), 4, 0);
    chip.write(at!(PWR.cr2()), 4, 6 << 1 | 1);
    wait_us(&mut chip, 100);
    assert_kept(&chip);
}
