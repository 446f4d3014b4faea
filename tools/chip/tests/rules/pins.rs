//! Pins and the lines that they drive.

use crate::clock::clocks;
use crate::spi;
use crate::steps::{pins, pulse};

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
