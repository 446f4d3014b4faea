//! Pins and the lines that they drive.

use crate::bench::wait_us;
use crate::clock::clocks;
use crate::spi;
use chip::chip::Chip;

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

trips! {
    alternate_function {
        one_that_the_pin_does_not_have: |chip| {
            clocks(chip);
            // PA9 has no function 0.
            let moder = chip.read(at!(GPIOA.moder()), 4) & !(3 << 18);
            chip.write(at!(GPIOA.moder()), 4, moder | 2 << 18);
        };
        another_units_than_the_board_needs: |chip| {
            spi::start(chip);
            // PA5 is TIM2's instead of SPI1's.
            chip.write(at!(GPIOA.afr(0)), 4, 0x5510_0000);
            spi::select(chip, true);
        };
    }
    floating_line {
        a_reset_that_nothing_drives: |chip| {
            clocks(chip);
            pins(chip);
            chip.write(at!(GPIOC.moder()), 4, 0xFFFF_7FFF);
        };
    }
    convst_width {
        two_stores_at_low_speed: |chip| {
            clocks(chip);
            pins(chip);
            chip.write(at!(GPIOC.ospeedr()), 4, 0);
            pulse(chip, 0);
        };
    }
}
