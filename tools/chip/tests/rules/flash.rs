//! The flash controller.

use crate::bench::{assert_kept, chip, clear, set, wait_us};
use crate::steps::{double_word, program, unlock};
use crate::swap::swapped;
use chip::peripheral::flash::Start;
use chip::rule::Rule;

/// A page's erase, of bank 2.
const ERASE: u32 = 1 << 1 | 1 << 11;

trips! {
    flash_key {
        one_that_is_none: |chip| chip.write(at!(FLASH.keyr()), 4, 1);
    }
    flash_locked {
        an_erase_without_the_keys: |chip| chip.write(at!(FLASH.cr()), 4, ERASE);
        a_write_while_it_works: |chip| {
            program(chip, false);
            chip.write(at!(FLASH.cr()), 4, ERASE);
            chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
            chip.write(at!(FLASH.cr()), 4, 1);
        };
    }
    flash_not_erased {
        the_same_place_twice: |chip| {
            program(chip, false);
            double_word(chip);
            double_word(chip);
        };
    }
    flash_double_word {
        the_second_half_first: |chip| {
            program(chip, false);
            chip.write_far(4, 4, 1);
        };
        a_store_that_is_not_announced: |chip| {
            unlock(chip);
            chip.write_far(0, 4, 1);
        };
    }
    flash_data_cache {
        on_while_bank_2_is_written: |chip| {
            program(chip, true);
            double_word(chip);
        };
    }
    flash_read_while_write {
        while_a_page_is_erased: |chip| {
            program(chip, false);
            chip.write(at!(FLASH.cr()), 4, ERASE);
            chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
            chip.read_far(0, 4);
        };
        while_a_double_word_is_programmed: |chip| {
            program(chip, false);
            chip.write_far(0, 4, 1);
            chip.write_far(4, 4, 2);
            chip.read_far(8, 4);
        };
    }
    flash_stale_cache {
        on_again_and_not_emptied: |chip| {
            program(chip, false);
            double_word(chip);
            set(chip, at!(FLASH.acr()), 1 << 10);
        };
    }
    flash_same_bank {
        the_page_of_the_code: |chip| {
            program(chip, false);
            chip.write(at!(FLASH.cr()), 4, 2);
            chip.write(at!(FLASH.cr()), 4, 2 | 1 << 16);
        };
        the_same_page_once_bank_2_runs: |chip| {
            swapped(chip);
            program(chip, false);
            chip.write(at!(FLASH.cr()), 4, ERASE);
            chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
        };
    }
}

mod flash_sticky_error {
    use super::*;

    #[test]
    fn stops_an_operation_until_it_is_cleared() {
        let start = Start {
            errors: 1 << 7,
            ..Start::default()
        };
        let mut chip = chip(start);
        program(&mut chip, false);
        double_word(&mut chip);
        let mut found = chip.findings.list().iter();
        assert!(found.any(|violation| violation.rule == Rule::FlashSticky));
        assert_eq!(chip.read_far(0, 4), u32::MAX, "not programmed");
        chip.findings.forgive(Rule::FlashSticky);
        chip.write(at!(FLASH.sr()), 4, 0xC3FA);
        double_word(&mut chip);
        assert_kept(&chip);
        assert_eq!(chip.read_far(0, 4), 1);
    }
}

#[test]
fn what_is_written_as_the_manual_wants_is_held_and_trips_none() {
    let mut chip = chip(Start::default());
    program(&mut chip, false);
    chip.write(at!(FLASH.cr()), 4, ERASE);
    chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
    wait_us(&mut chip, 25_000);
    chip.write(at!(FLASH.cr()), 4, 1);
    double_word(&mut chip);
    chip.write(at!(FLASH.cr()), 4, 1 << 31);
    set(&mut chip, at!(FLASH.acr()), 1 << 12);
    clear(&mut chip, at!(FLASH.acr()), 1 << 12);
    set(&mut chip, at!(FLASH.acr()), 1 << 10);
    let words = [0, 4, 8].map(|offset| chip.read_far(offset, 4));
    assert_eq!(words, [1, 2, u32::MAX]);
    assert_kept(&chip);
}
