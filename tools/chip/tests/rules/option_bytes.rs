//! Option bytes: how they are written, and when they are in force.

use crate::bench::{assert_kept, chip, wait_us};
use crate::steps::unlock;
use chip::chip::Chip;
use chip::peripheral::flash::Start;
use chip::peripheral::rcc::Cause;

fn unlock_options(chip: &mut Chip) {
    unlock(chip);
    for key in [0x0819_2A3B, 0x4C5D_6E7F] {
        chip.write(at!(FLASH.optkeyr()), 4, key);
    }
}

/// The level of the brown-out reset.
fn level(chip: &mut Chip) -> u32 {
    chip.read(at!(FLASH.optr()), 4) >> 8 & 7
}

trips! {
    option_bytes {
        written_without_their_keys: |chip| {
            unlock(chip);
            let options = chip.read(at!(FLASH.optr()), 4);
            chip.write(at!(FLASH.optr()), 4, options);
        };
        a_key_that_is_none_of_theirs: |chip| {
            unlock(chip);
            chip.write(at!(FLASH.optkeyr()), 4, 0x4567_0123);
        };
        a_start_without_their_keys: |chip| {
            unlock(chip);
            chip.write(at!(FLASH.cr()), 4, 1 << 30 | 1 << 17);
        };
    }
}

#[test]
fn they_are_in_force_after_their_load_and_not_before() {
    let mut chip = chip(Start::default());
    assert_eq!(level(&mut chip), 4);
    unlock_options(&mut chip);
    let options = chip.read(at!(FLASH.optr()), 4) & !(7 << 8);
    chip.write(at!(FLASH.optr()), 4, options | 3 << 8);
    chip.write(at!(FLASH.cr()), 4, 1 << 17);
    assert_eq!(chip.read(at!(FLASH.sr()), 4) >> 16 & 1, 1, "busy");
    wait_us(&mut chip, 30_000);
    chip.reset(Cause::Software).expect("no host");
    assert_eq!(level(&mut chip), 4, "a plain reset loads nothing");
    unlock_options(&mut chip);
    assert!(!chip.loads_options());
    chip.write(at!(FLASH.cr()), 4, 1 << 27);
    assert!(chip.loads_options());
    chip.reset(Cause::Options).expect("no host");
    assert_eq!(level(&mut chip), 3);
    assert_kept(&chip);
}
