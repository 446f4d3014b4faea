//! Watchdog, supply detector, and the serial line's rate.

use crate::bench::wait_us;
use crate::clock::{clocks, full_speed};

trips! {
    watchdog {
        one_that_nobody_feeds: |chip| {
            crate::steps::watchdog(chip);
            // The longest it can be after reset: 4096 cycles of 4 / 32 kHz.
            wait_us(chip, 513_000);
        };
    }
    watchdog_key {
        a_register_without_its_key: |chip| chip.write(at!(IWDG.pr()), 4, 3);
    }
    supply_warning {
        a_level_below_the_reset: |chip| {
            clocks(chip);
            chip.write(at!(PWR.cr2()), 4, 5 << 1 | 1);
        };
    }
    baud_rate {
        twice_the_controllers: |chip| {
            full_speed(chip);
            chip.write(at!(USART1.brr()), 4, 85);
            chip.write(at!(USART1.cr1()), 4, 1);
        };
    }
}
