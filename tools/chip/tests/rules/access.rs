//! What every access to a register must be.

use crate::bench::set;
use crate::clock::clocks;
use crate::spi;

trips! {
    unmodelled_register {
        a_unit_that_the_model_does_not_have: |chip| chip.write(0x4000_4400, 4, 0);
        a_place_without_a_register: |chip| chip.write(0x4002_1FFC, 4, 0);
    }
    reserved_bit {
        one_of_the_clock_controller: |chip| set(chip, at!(RCC.cr()), 1 << 1);
    }
    read_only_register {
        the_pins_of_a_port: |chip| {
            clocks(chip);
            chip.write(at!(GPIOA.idr()), 4, 1);
        };
    }
    access_width {
        a_byte_of_a_whole_register: |chip| chip.write(at!(RCC.cr()), 1, 0);
        two_bytes_into_a_fifo: |chip| {
            spi::start(chip);
            chip.write(at!(SPI1.dr16()), 2, 0);
        };
    }
    peripheral_clock {
        a_bus_without_clock: |chip| chip.write(at!(SPI1.cr1()), 4, 0);
    }
}
