//! Banks that change places.

use crate::bench::{assert_kept, chip, wait_us};
use crate::clock::clocks;
use crate::steps::{double_word, program};
use chip::chip::Chip;
use chip::peripheral::flash::Start;
use chip::peripheral::rcc::Cause;

/// FB_MODE, and a place from which code runs while it is set.
const SWAPPED: u32 = 1 << 8;
const RAM: u32 = 0x2000_0000;
/// Prefetch and caches on, and the bits that empty these.
const CACHES: u32 = 7 << 8;
const CACHE_RESETS: u32 = 3 << 11;

/// Prefetch and caches off and empty, code in RAM.
fn without_caches(chip: &mut Chip) {
    clocks(chip);
    chip.running_at = RAM;
    let off = chip.read(at!(FLASH.acr()), 4) & !CACHES;
    for acr in [off, off | CACHE_RESETS, off] {
        chip.write(at!(FLASH.acr()), 4, acr);
    }
}

/// The banks have changed places, as they should.
pub fn swapped(chip: &mut Chip) {
    without_caches(chip);
    chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
}

/// This cache is on again without having been emptied.
fn stale_after_swap(chip: &mut Chip, cache: u32) {
    clocks(chip);
    chip.running_at = RAM;
    let off = chip.read(at!(FLASH.acr()), 4) & !CACHES;
    chip.write(at!(FLASH.acr()), 4, off);
    chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
    chip.write(at!(FLASH.acr()), 4, off | cache);
}

trips! {
    bank_swap {
        with_caches_on: |chip| {
            clocks(chip);
            chip.running_at = RAM;
            chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
        };
        under_the_code_that_runs: |chip| {
            without_caches(chip);
            chip.running_at = 0x0800_0100;
            chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
        };
        while_the_controller_works: |chip| {
            program(chip, false);
            without_caches(chip);
            chip.write_far(0, 4, 1);
            chip.write_far(4, 4, 2);
            chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
        };
    }
    flash_stale_cache {
        the_instruction_cache: |chip| stale_after_swap(chip, 1 << 9);
        the_data_cache: |chip| stale_after_swap(chip, 1 << 10);
    }
}

#[test]
fn banks_that_change_places_are_the_same_banks_and_a_reset_takes_it_back() {
    let mut chip = chip(Start::default());
    program(&mut chip, false);
    double_word(&mut chip);
    wait_us(&mut chip, 100);
    chip.write(at!(FLASH.cr()), 4, 1 << 31);
    swapped(&mut chip);
    assert!(chip.take_remapped() && chip.banks_swapped());
    // Bank 1 is the other one now: its pages are those without BKER.
    assert_eq!(chip.read_far(0, 4), u32::MAX);
    program(&mut chip, false);
    double_word(&mut chip);
    wait_us(&mut chip, 100);
    chip.write(at!(FLASH.cr()), 4, 2);
    chip.write(at!(FLASH.cr()), 4, 2 | 1 << 16);
    wait_us(&mut chip, 25_000);
    assert_eq!(chip.read_far(0, 4), u32::MAX, "erased");
    chip.reset(Cause::Software).expect("no host");
    assert!(!chip.banks_swapped());
    assert_eq!(chip.read_far(0, 4), 1, "bank 2 holds what was written");
    assert_kept(&chip);
}
