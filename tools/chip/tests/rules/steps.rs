//! Steps on the way to what a test is about: what a right image does.

use crate::bench::{clear, wait_us};
use chip::chip::Chip;

/// Starts the watchdog.
pub fn watchdog(chip: &mut Chip) {
    chip.write(at!(IWDG.kr()), 4, 0xCCCC);
}

/// Pins as the board's.
pub fn pins(chip: &mut Chip) {
    chip.write(at!(GPIOA.bsrr()), 4, 1 << 4);
    chip.write(at!(GPIOB.bsrr()), 4, 1);
    chip.write(at!(GPIOA.afr(0)), 4, 0x5550_0000);
    chip.write(at!(GPIOA.afr(1)), 4, 0x0000_0770);
    let moder = chip.read(at!(GPIOA.moder()), 4) & !0x003C_FF00;
    chip.write(at!(GPIOA.moder()), 4, moder | 0x0028_A900);
    let moder = chip.read(at!(GPIOB.moder()), 4) & !0x3;
    chip.write(at!(GPIOB.moder()), 4, moder | 1);
    // CONVST and RESET are outputs of the highest speed.
    chip.write(at!(GPIOC.ospeedr()), 4, 0xF << 12);
    chip.write(at!(GPIOC.moder()), 4, 0xFFFF_5FFF);
}

/// A pulse of CONVST.
pub fn pulse(chip: &mut Chip, us: u64) {
    chip.write(at!(GPIOC.bsrr()), 4, 1 << 6);
    wait_us(chip, us);
    chip.write(at!(GPIOC.bsrr()), 4, 1 << 22);
}

/// Unlocks the flash controller.
pub fn unlock(chip: &mut Chip) {
    for key in [0x4567_0123, 0xCDEF_89AB] {
        chip.write(at!(FLASH.keyr()), 4, key);
    }
}

/// Data cache off and reset, controller unlocked, programming.
pub fn program(chip: &mut Chip, data_cache: bool) {
    if !data_cache {
        clear(chip, at!(FLASH.acr()), 1 << 10);
    }
    unlock(chip);
    chip.write(at!(FLASH.cr()), 4, 1);
}

/// Programs a double word and waits.
pub fn double_word(chip: &mut Chip) {
    chip.write_far(0, 4, 1);
    chip.write_far(4, 4, 2);
    wait_us(chip, 100);
}
